// What goes wrong with real robots, each by its name: simulated runs through a real floor plan,
// given to the localizer itself. In all cases, an accepted pose must be the true one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include <cornerfix/localizer.hpp>
#include <cornerfix/map_image.hpp>
#include <cornerfix/mapper.hpp>

#include "evaluation/metrics/localization_score.hpp"
#include "evaluation/simulation/run_simulator.hpp"
#include "evaluation/simulation/scenes.hpp"

namespace cornerfix::evaluation {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::uint64_t kSeeds[] = {11, 12, 13};

const OccupancyGrid& building() {
  static const OccupancyGrid grid =
      *read_map_files(CORNERFIX_SOURCE_DIR "/tests/data/willow_full_0.05.yaml");
  return grid;
}

/// Of the whole building, made once: by a lidar that sees far.
const LocalizationMapPtr& building_map() {
  static const LocalizationMapPtr map = [] {
    const auto log =
        simulate_run(building(), {.beams = 541, .length_m = 500.0, .step_m = 0.4, .seed = 1});
    return map_from(*log, log->scans.size(), {}).map;
  }();
  return map;
}

/// A robot's drive; three in the building, from other places.
struct Moment {
  RobotScan scan;
  Pose2 T_map_base_link;
};

std::vector<Moment> moments_of(RunOptions options, std::uint64_t seed) {
  options.seed = seed;
  const auto log = simulate_run(building(), options);
  EXPECT_TRUE(log.ok()) << log.error().message;
  std::vector<Moment> moments;
  for (const LogScan& scan : log->scans) {
    moments.push_back({{scan.scan, Pose2{}, scan.T_odom_laser}, *scan.T_map_laser});
  }
  return moments;
}

RunOptions drive_with(double field_of_view_rad, std::size_t beams, double range_max_m) {
  return {.field_of_view_rad = field_of_view_rad,
          .beams = beams,
          .range_max_m = range_max_m,
          .length_m = 25.0,
          .step_m = 0.25};
}

/// 270 degrees, 541 beams, 30 m.
RunOptions usual_drive() { return drive_with(1.5 * kPi, 541, 30.0); }

struct Outcome {
  std::size_t localized = 0;
  std::size_t wrong = 0;  ///< Of those.
  bool first_is_wrong = false;
  bool ends_localized = false;
};

Outcome outcome_of(const std::vector<Moment>& moments) {
  Localizer localizer({building_map()}, {});
  Outcome outcome;
  for (const Moment& moment : moments) {
    const Answer answer = localizer.process(moment.scan);
    outcome.ends_localized = answer.pose.has_value();
    if (!answer.pose) continue;
    ++outcome.localized;
    const Pose2& pose = answer.pose->T_map_base_link;
    const bool is_wrong = !is_correct(pose_error(pose, moment.T_map_base_link));
    if (outcome.localized == 1) outcome.first_is_wrong = is_wrong;
    outcome.wrong += is_wrong ? 1 : 0;
  }
  return outcome;
}

using Trouble = std::function<void(std::vector<Moment>&, std::mt19937_64&)>;

/// Every run ends with a localized robot, and no answer has a wrong pose.
void expect_found(const RunOptions& options, const Trouble& trouble = {}) {
  for (const std::uint64_t seed : kSeeds) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::vector<Moment> moments = moments_of(options, seed);
    std::mt19937_64 random(seed);
    if (trouble) trouble(moments, random);
    const Outcome outcome = outcome_of(moments);
    EXPECT_EQ(outcome.wrong, 0U) << "of " << outcome.localized;
    EXPECT_TRUE(outcome.ends_localized)
        << "of " << moments.size() << " scans " << outcome.localized << " localized";
  }
}

/// The motion between scans by odometry, changed.
void retell_odometry(std::vector<Moment>& moments,
                     const std::function<Pose2(const Pose2&)>& retell) {
  Pose2 T_before = *moments.front().scan.T_odom_base_link;
  Pose2 T_told = T_before;
  for (std::size_t i = 1; i < moments.size(); ++i) {
    Pose2& T_odom_base_link = *moments[i].scan.T_odom_base_link;
    const Pose2 motion = inverse(T_before) * T_odom_base_link;
    T_before = T_odom_base_link;
    T_told = T_told * retell(motion);
    T_odom_base_link = T_told;
  }
}

TEST(HardDrives, WithoutOdometry) {
  expect_found(usual_drive(), [](std::vector<Moment>& moments, auto&) {
    for (Moment& moment : moments) moment.scan.T_odom_base_link.reset();
  });
}

TEST(HardDrives, OdometryThatIsTenPerCentTooLong) {
  expect_found(usual_drive(), [](std::vector<Moment>& moments, auto&) {
    retell_odometry(moments, [](const Pose2& motion) {
      return Pose2{1.1 * motion.x, 1.1 * motion.y, 1.1 * motion.yaw};
    });
  });
}

TEST(HardDrives, OdometryThatIsTenPerCentTooShort) {
  expect_found(usual_drive(), [](std::vector<Moment>& moments, auto&) {
    retell_odometry(moments, [](const Pose2& motion) {
      return Pose2{0.9 * motion.x, 0.9 * motion.y, 0.9 * motion.yaw};
    });
  });
}

/// The wheels turn and the robot does not move, twice on the way.
TEST(HardDrives, WheelsThatSlipByHalfAMetre) {
  expect_found(usual_drive(), [](std::vector<Moment>& moments, auto&) {
    std::size_t scan = 0;
    retell_odometry(moments, [&](const Pose2& motion) {
      const bool slips = ++scan == 20 || scan == 60;
      return slips ? motion * Pose2{0.5, 0.0, 0.0} : motion;
    });
  });
}

TEST(HardDrives, TwoOfThreeScansMissing) {
  expect_found(usual_drive(), [](std::vector<Moment>& moments, std::mt19937_64& random) {
    std::erase_if(moments, [&](const Moment&) { return random() % 3 != 0; });
  });
}

/// For two metres nothing comes from the lidar.
TEST(HardDrives, AGapInTheScans) {
  expect_found(usual_drive(), [](std::vector<Moment>& moments, auto&) {
    moments.erase(moments.begin() + 30, moments.begin() + 38);
  });
}

/// The laser sits at the robot's front left corner and looks outwards.
TEST(HardDrives, ALaserThatIsMountedAtACorner) {
  expect_found(usual_drive(), [](std::vector<Moment>& moments, auto&) {
    const Pose2 T_base_link_laser{0.4, 0.25, kPi / 4.0};
    for (Moment& moment : moments) {
      moment.scan.T_base_link_laser = T_base_link_laser;
      moment.scan.T_odom_base_link = *moment.scan.T_odom_base_link * inverse(T_base_link_laser);
      moment.T_map_base_link = moment.T_map_base_link * inverse(T_base_link_laser);
    }
  });
}

TEST(HardDrives, ALaserThatHangsUpsideDownIsNotMisled) {
  for (const std::uint64_t seed : kSeeds) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::vector<Moment> moments = moments_of(usual_drive(), seed);
    for (Moment& moment : moments) std::ranges::reverse(moment.scan.scan.ranges);
    EXPECT_EQ(outcome_of(moments).wrong, 0U);
  }
}

/// A laser that looks down by five degrees, which its mount does not state, sees the floor where it
/// should see far walls. The robot may stay without an answer; its first pose must be right. Later
/// poses may be wrong along corridors, because the hits on the floor move with the robot.
TEST(HardDrives, ALaserThatLooksDownByFiveDegreesGivesNoWrongFirstPose) {
  constexpr double kHeight = 0.4;  // [m] above the floor
  const double pitch = 5.0 * kPi / 180.0;
  for (const std::uint64_t seed : kSeeds) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::vector<Moment> moments = moments_of(usual_drive(), seed);
    for (Moment& moment : moments) {
      LaserScan& scan = moment.scan.scan;
      for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
        const double slope = std::sin(pitch) * std::cos(scan.bearing(beam));
        const double flat = std::sqrt(1.0 - slope * slope);
        const double to_floor = slope > 0.0 ? kHeight / slope : scan.range_max + 1.0;
        const double to_wall = static_cast<double>(scan.ranges[beam]) / flat;
        scan.ranges[beam] = static_cast<float>(std::fmin(to_wall, to_floor));
      }
    }
    EXPECT_FALSE(outcome_of(moments).first_is_wrong);
  }
}

struct NamedLidar {
  const char* name;
  double field_of_view_rad;
  std::size_t beams;
  double range_max_m;
};

class HardDrivesWithLidar : public ::testing::TestWithParam<NamedLidar> {};

TEST_P(HardDrivesWithLidar, FindTheRobot) {
  const NamedLidar& lidar = GetParam();
  expect_found(drive_with(lidar.field_of_view_rad, lidar.beams, lidar.range_max_m));
}

INSTANTIATE_TEST_SUITE_P(
    Lidars, HardDrivesWithLidar,
    ::testing::Values(NamedLidar{"180deg_180beams_8m", kPi, 180, 8.0},
                      NamedLidar{"180deg_361beams_80m", kPi, 361, 80.0},
                      NamedLidar{"270deg_1081beams_30m", 1.5 * kPi, 1081, 30.0},
                      NamedLidar{"360deg_360beams_12m", 2.0 * kPi, 360, 12.0},
                      NamedLidar{"360deg_2000beams_80m", 2.0 * kPi, 2000, 80.0}),
    [](const auto& test) { return std::string(test.param.name); });

/// Four metres are too few to be found soon in a large building, but never a reason for a wrong
/// pose.
TEST(HardDrives, ALidarThatSeesFourMetresIsNotMisled) {
  for (const std::uint64_t seed : kSeeds) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Outcome outcome = outcome_of(moments_of(drive_with(2.0 * kPi, 360, 4.0), seed));
    EXPECT_EQ(outcome.wrong, 0U) << "of " << outcome.localized;
  }
}

/// The building with boxes of up to a metre in its free space.
OccupancyGrid furnished(std::uint64_t seed) {
  OccupancyGrid grid = building();
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> column(0, grid.width - 1), row(0, grid.height - 1),
      cells(8, 20);
  for (int placed = 0; placed < 250;) {
    const CellIndex low{column(random), row(random)};
    if (grid.at(low) != Cell::kFree) continue;
    const CellIndex high{low.column + cells(random), low.row + cells(random)};
    for (int r = low.row; r < std::min(high.row, grid.height); ++r) {
      for (int c = low.column; c < std::min(high.column, grid.width); ++c) {
        grid.cells[grid.offset({c, r})] = Cell::kOccupied;
      }
    }
    ++placed;
  }
  return grid;
}

/// The furniture of both, for ways that are free in both.
OccupancyGrid both(OccupancyGrid first, const OccupancyGrid& second) {
  for (std::size_t i = 0; i < first.cells.size(); ++i) {
    if (second.cells[i] == Cell::kOccupied) first.cells[i] = Cell::kOccupied;
  }
  return first;
}

TEST(HardDrives, AMapUpdatedAfterTheBuildingWasRefurnishedIsAsGoodAsANewOne) {
  const OccupancyGrid before = furnished(1);
  const OccupancyGrid after = furnished(2);
  const OccupancyGrid always = both(before, after);
  RunOptions options = drive_with(kPi, 181, 8.0);
  options.range_noise_m = 0.03;
  const auto log_of = [&](const OccupancyGrid& inside, double length_m, double start_s,
                          std::uint64_t seed) {
    options.length_m = length_m;
    options.start_s = start_s;
    options.seed = seed;
    return *simulate_run(always, options, &inside);
  };
  const RecordedLog first = log_of(before, 500.0, 0.0, 1);
  const RecordedLog later = log_of(after, 500.0, 86400.0, 2);
  RecordedLog drives = first;
  drives.scans.insert(drives.scans.end(), later.scans.begin(), later.scans.end());
  const RecordedLog robot = log_of(after, 200.0, 0.0, 3);

  EvaluationOptions asked;
  asked.starts = 25;
  asked.max_distance_m = 5.0;
  asked.track_m = 0.0;
  const auto fixes_in_map_of = [&](const RecordedLog& mapping) {
    const Evaluation evaluation = map_from(mapping, mapping.scans.size(), {});
    const auto records =
        evaluate(robot, 0, {evaluation.map}, 0, evaluation.mapping_positions, asked, {});
    const auto count = [&](Verdict verdict) {
      return std::ranges::count(records, verdict, &StartRecord::verdict);
    };
    EXPECT_EQ(count(Verdict::kWrong), 0);
    return count(Verdict::kCorrect);
  };
  const auto stale = fixes_in_map_of(first);
  const auto updated = fixes_in_map_of(drives);
  const auto made_anew = fixes_in_map_of(later);
  EXPECT_GT(updated, stale);
  EXPECT_GE(updated, made_anew - 1);
  RecordProperty("stale", static_cast<int>(stale));
  RecordProperty("updated", static_cast<int>(updated));
  RecordProperty("made_anew", static_cast<int>(made_anew));
}

// Equal rooms, whose doors were opened and closed since they were mapped. From these scans on, the
// doors of other rooms resemble those that the robot sees.
TEST(HardDrives, DoorsThatChangedDoNotDecideBetweenCopiesOfACorridor) {
  const OccupancyGrid mapped = make_scene(SceneKind::kCorridors, 6, 1);
  const OccupancyGrid present = make_scene(SceneKind::kCorridors, 6, 2);
  RunOptions options = drive_with(2.0 * kPi, 360, 12.0);
  options.range_noise_m = 0.03;
  options.length_m = 250.0;
  options.step_m = 0.1;
  options.seed = 105;
  const auto run = simulate_run(mapped, options, &present);
  ASSERT_TRUE(run.ok()) << run.error().message;
  auto content = map_from_grid(mapped, {});
  ASSERT_TRUE(content.ok()) << content.error().message;
  const auto map =
      std::make_shared<const LocalizationMap>("corridors", 1, std::move(content->content));

  constexpr std::size_t kScans = 240;
  for (const std::size_t start : {124U, 1124U, 1499U, 1624U}) {
    ASSERT_GE(run->scans.size(), start + kScans);
    Localizer localizer({map}, {});
    std::size_t wrong = 0;
    for (std::size_t i = start; i < start + kScans; ++i) {
      const LogScan& scan = run->scans[i];
      const Answer answer = localizer.process({scan.scan, Pose2{}, scan.T_odom_laser});
      if (!answer.pose) continue;
      wrong += is_correct(pose_error(answer.pose->T_map_base_link, *scan.T_map_laser)) ? 0 : 1;
    }
    EXPECT_EQ(wrong, 0U) << "from scan " << start;
  }
}

}  // namespace
}  // namespace cornerfix::evaluation

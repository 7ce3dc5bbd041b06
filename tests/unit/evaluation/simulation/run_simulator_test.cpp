#include "evaluation/simulation/run_simulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "evaluation/datasets/log_writer.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::evaluation {
namespace {

constexpr double kResolution = 0.05;
constexpr double kWidth = 12.0;
constexpr double kHeight = 8.0;

void fill(OccupancyGrid& grid, const Point2& low, const Point2& high, Cell cell) {
  const Pose2 T_grid_map = inverse(grid.T_map_grid);
  const CellIndex first = grid.cell_of(T_grid_map * low);
  const CellIndex last = grid.cell_of(T_grid_map * high);
  for (int row = first.row; row <= last.row; ++row) {
    for (int column = first.column; column <= last.column; ++column) {
      if (grid.contains({column, row})) grid.cells[grid.offset({column, row})] = cell;
    }
  }
}

/// Free inside [0, 12] x [0, 8], walls 0.1 m thick about it, unknown beyond.
OccupancyGrid box_room() {
  OccupancyGrid grid;
  grid.resolution = kResolution;
  grid.T_map_grid = {-1.0, -1.0, 0.0};
  grid.width = static_cast<int>((kWidth + 2.0) / kResolution);
  grid.height = static_cast<int>((kHeight + 2.0) / kResolution);
  grid.cells.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                    Cell::kUnknown);
  constexpr double kInside = kResolution / 2.0;  // Of the first cell within an edge.
  fill(grid, {-0.1 + kInside, -0.1 + kInside}, {kWidth + 0.1 - kInside, kHeight + 0.1 - kInside},
       Cell::kOccupied);
  fill(grid, {kInside, kInside}, {kWidth - kInside, kHeight - kInside}, Cell::kFree);
  return grid;
}

/// Two rooms with a door between them.
OccupancyGrid two_rooms() {
  OccupancyGrid grid = box_room();
  fill(grid, {6.0, 0.0}, {6.1, 3.0}, Cell::kOccupied);
  fill(grid, {6.0, 4.2}, {6.1, kHeight}, Cell::kOccupied);
  return grid;
}

RunOptions quiet_run() {
  RunOptions options;
  options.beams = 31;
  options.length_m = 15.0;
  options.range_noise_m = 0.0;
  options.drift = 0.0;
  return options;
}

RecordedLog simulated(const OccupancyGrid& grid, const RunOptions& options,
                      const OccupancyGrid* inside = nullptr) {
  Result<RecordedLog> log = simulate_run(grid, options, inside);
  EXPECT_TRUE(log.ok()) << (log.ok() ? "" : log.error().message);
  return log.ok() ? std::move(*log) : RecordedLog{};
}

bool same_ranges(const LogScan& a, const LogScan& b) {
  // Bit by bit, since NaN is no return and equals nothing.
  return a.scan.ranges.size() == b.scan.ranges.size() &&
         std::memcmp(a.scan.ranges.data(), b.scan.ranges.data(),
                     a.scan.ranges.size() * sizeof(float)) == 0;
}

bool same_scans(const RecordedLog& a, const RecordedLog& b) {
  return std::equal(a.scans.begin(), a.scans.end(), b.scans.begin(), b.scans.end(), same_ranges);
}

bool same_poses(const RecordedLog& a, const RecordedLog& b) {
  return std::equal(a.scans.begin(), a.scans.end(), b.scans.begin(), b.scans.end(),
                    [](const LogScan& x, const LogScan& y) {
                      return x.T_map_laser == y.T_map_laser && x.T_odom_laser == y.T_odom_laser;
                    });
}

TEST(RunSimulator, GivesTheSameLogForTheSameSeed) {
  RunOptions options = quiet_run();
  options.range_noise_m = 0.02;
  options.drift = 0.02;
  options.people = 2;
  options.boxes = 2;
  const RecordedLog first = simulated(two_rooms(), options);
  const RecordedLog second = simulated(two_rooms(), options);
  EXPECT_TRUE(same_poses(first, second));
  EXPECT_TRUE(same_scans(first, second));
  options.seed = 2;
  EXPECT_FALSE(same_poses(first, simulated(two_rooms(), options)));
}

TEST(RunSimulator, StampsBeginAtTheGivenStart) {
  const auto log = simulate_run(box_room(), {.beams = 11, .length_m = 1.0, .start_s = 86400.0});
  ASSERT_TRUE(log);
  EXPECT_EQ(log->scans[0].scan.stamp, 86400.0);
  EXPECT_NEAR(log->scans[1].scan.stamp, 86400.1, 1e-9);
  EXPECT_FALSE(simulate_run(box_room(), {.start_s = std::nan("")}));
}

TEST(RunSimulator, MeasuresABoxRoomAsGeometryDoes) {
  for (const LogScan& recorded : simulated(box_room(), quiet_run()).scans) {
    const Pose2& pose = *recorded.T_map_laser;
    for (std::size_t beam = 0; beam < recorded.scan.ranges.size(); ++beam) {
      if (!recorded.scan.has_return(beam)) continue;  // A few are dropped on purpose.
      const double c = std::cos(pose.yaw + recorded.scan.bearing(beam));
      const double s = std::sin(pose.yaw + recorded.scan.bearing(beam));
      const double to_x = std::max((kWidth - pose.x) / c, -pose.x / c);
      const double to_y = std::max((kHeight - pose.y) / s, -pose.y / s);
      ASSERT_NEAR(recorded.scan.ranges[beam], std::min(to_x, to_y), 1e-3);
    }
  }
}

TEST(RunSimulator, LosesFewBeamsInAClosedRoom) {
  std::size_t returns = 0;
  std::size_t beams = 0;
  for (const LogScan& recorded : simulated(box_room(), quiet_run()).scans) {
    for (std::size_t beam = 0; beam < recorded.scan.ranges.size(); ++beam, ++beams) {
      if (recorded.scan.has_return(beam)) ++returns;
    }
  }
  EXPECT_GT(static_cast<double>(returns), 0.99 * static_cast<double>(beams));
}

TEST(RunSimulator, DrivesTheLengthInSteps) {
  const RunOptions options = quiet_run();
  const RecordedLog log = simulated(two_rooms(), options);
  double length = 0.0;
  for (std::size_t i = 1; i < log.scans.size(); ++i) {
    const Pose2& last = *log.scans[i - 1].T_map_laser;
    const Pose2& pose = *log.scans[i].T_map_laser;
    EXPECT_LE(distance(last, pose), options.step_m + 1e-9);
    EXPECT_LE(angle_between(last, pose), 0.15 + 1e-9);
    EXPECT_GT(log.scans[i].scan.stamp, log.scans[i - 1].scan.stamp);
    length += distance(last, pose);
  }
  EXPECT_NEAR(length, options.length_m, 1.0);
}

TEST(RunSimulator, NeverDrivesThroughWalls) {
  const OccupancyGrid grid = two_rooms();
  RunOptions options = quiet_run();
  options.beams = 2;
  options.length_m = 100.0;
  bool was_left = false;
  bool was_right = false;
  for (const LogScan& recorded : simulated(grid, options).scans) {
    const Point2 position = recorded.T_map_laser->translation();
    was_left = was_left || position.x() < 5.0;
    was_right = was_right || position.x() > 7.0;
    for (double angle = 0.0; angle < 6.28; angle += 0.1) {
      const Point2 rim = position + 0.25 * Point2{std::cos(angle), std::sin(angle)};
      ASSERT_EQ(grid.at(grid.cell_of(inverse(grid.T_map_grid) * rim)), Cell::kFree)
          << position.transpose();
    }
  }
  EXPECT_TRUE(was_left && was_right);  // Through the door, then.
}

TEST(RunSimulator, VisitsAllOfTheBuilding) {
  RunOptions options = quiet_run();
  options.beams = 2;
  options.length_m = 120.0;
  const RecordedLog log = simulated(two_rooms(), options);
  for (double x = 1.0; x < kWidth; x += 2.0) {
    for (double y = 1.0; y < kHeight; y += 2.0) {
      EXPECT_TRUE(std::any_of(log.scans.begin(), log.scans.end(),
                              [&](const LogScan& recorded) {
                                return distance(*recorded.T_map_laser, {x, y, 0.0}) < 2.5;
                              }))
          << x << ", " << y;
    }
  }
}

TEST(RunSimulator, KeepsPerfectOdometryWithoutDrift) {
  const RecordedLog log = simulated(two_rooms(), quiet_run());
  const Pose2 T_map_odom = *log.scans.front().T_map_laser;
  for (const LogScan& recorded : log.scans) {
    EXPECT_LT(distance(T_map_odom * *recorded.T_odom_laser, *recorded.T_map_laser), 1e-6);
  }
}

TEST(RunSimulator, DriftLeavesPosesAndScansAsTheyWere) {
  const RecordedLog straight = simulated(two_rooms(), quiet_run());
  RunOptions options = quiet_run();
  options.drift = 0.05;
  const RecordedLog drifting = simulated(two_rooms(), options);
  EXPECT_TRUE(same_scans(straight, drifting));
  EXPECT_EQ(straight.scans.back().T_map_laser, drifting.scans.back().T_map_laser);
  EXPECT_GT(distance(*straight.scans.back().T_odom_laser, *drifting.scans.back().T_odom_laser),
            0.05);
}

TEST(RunSimulator, AFaultChangesTheOdometryOnly) {
  RunOptions options = quiet_run();
  const RecordedLog sound = simulated(two_rooms(), options);
  options.odometry_fault = OdometryFaultKind::kZero;
  const RecordedLog faulty = simulated(two_rooms(), options);
  EXPECT_TRUE(same_scans(sound, faulty));
  ASSERT_FALSE(faulty.scans.empty());
  for (std::size_t i = 0; i < faulty.scans.size(); ++i) {
    EXPECT_EQ(faulty.scans[i].T_map_laser, sound.scans[i].T_map_laser);
    EXPECT_EQ(faulty.scans[i].T_odom_laser, Pose2{});
  }
}

TEST(RunSimulator, IsDescribedByItsMapItsSeedAndItsFault) {
  RunOptions options;
  options.seed = 7;
  options.people = 2;
  EXPECT_EQ(describe_run("attic.yaml", options),
            "simulated run in attic.yaml, seed 7, noise 0.02 m, drift 0.02, people 2, boxes 0");
  options.odometry_fault = OdometryFaultKind::kJump;
  EXPECT_EQ(describe_run("attic.yaml", options),
            "simulated run in attic.yaml, seed 7, noise 0.02 m, drift 0.02, people 2, boxes 0, "
            "odometry fault jump");
}

TEST(RunSimulator, PeopleChangeScansButNotPoses) {
  const RecordedLog alone = simulated(two_rooms(), quiet_run());
  RunOptions options = quiet_run();
  options.people = 5;
  const RecordedLog crowded = simulated(two_rooms(), options);
  EXPECT_TRUE(same_poses(alone, crowded));
  EXPECT_FALSE(same_scans(alone, crowded));
}

TEST(RunSimulator, BoxesChangeScansButNotPosesAndStayOffThePath) {
  const RecordedLog empty = simulated(two_rooms(), quiet_run());
  RunOptions options = quiet_run();
  options.boxes = 5;
  const RecordedLog furnished = simulated(two_rooms(), options);
  EXPECT_TRUE(same_poses(empty, furnished));
  EXPECT_FALSE(same_scans(empty, furnished));
  for (const LogScan& recorded : furnished.scans) {
    EXPECT_GT(
        *std::min_element(recorded.scan.ranges.begin(), recorded.scan.ranges.end(),
                          [](float a, float b) { return std::isnan(b) ? !std::isnan(a) : a < b; }),
        0.25F);
  }
}

TEST(RunSimulator, SeesTheBuildingThatItDrivesInside) {
  OccupancyGrid later = box_room();
  fill(later, {5.0, 3.0}, {7.0, 5.0}, Cell::kOccupied);  // A new pillar.
  const OccupancyGrid map = box_room();
  for (const LogScan& recorded : simulated(map, quiet_run(), &later).scans) {
    const Point2 p = recorded.T_map_laser->translation();
    EXPECT_FALSE(p.x() > 5.0 && p.x() < 7.0 && p.y() > 3.0 && p.y() < 5.0);
  }
  EXPECT_FALSE(same_scans(simulated(later, quiet_run()), simulated(map, quiet_run())));
  EXPECT_TRUE(same_scans(simulated(later, quiet_run()), simulated(map, quiet_run(), &later)));
}

TEST(RunSimulator, TakesTheFrameOfATurnedMap) {
  OccupancyGrid turned = two_rooms();
  const Pose2 T{30.0, -4.0, 2.0};
  turned.T_map_grid = T * turned.T_map_grid;
  const RecordedLog log = simulated(two_rooms(), quiet_run());
  const RecordedLog turned_log = simulated(turned, quiet_run());
  ASSERT_EQ(log.scans.size(), turned_log.scans.size());
  EXPECT_LT(distance(T * *log.scans.back().T_map_laser, *turned_log.scans.back().T_map_laser),
            1e-6);
}

TEST(RunSimulator, DoesNotLookTwiceWhereAFullTurnBegins) {
  RunOptions options = quiet_run();
  options.field_of_view_rad = 2.0 * std::numbers::pi;
  options.beams = 360;
  options.length_m = 1.0;
  const RecordedLog log = simulated(box_room(), options);
  EXPECT_NEAR(log.header.lidar.angle_increment, std::numbers::pi / 180.0, 1e-12);
}

TEST(RunSimulator, RefusesAMapWithoutSpaceToDrive) {
  OccupancyGrid full = box_room();
  std::fill(full.cells.begin(), full.cells.end(), Cell::kOccupied);
  const Result<RecordedLog> log = simulate_run(full, quiet_run());
  ASSERT_FALSE(log.ok());
  EXPECT_EQ(log.error().code, ErrorCode::kInvalidArgument);
}

TEST(RunSimulator, RefusesBrokenOptions) {
  const auto field_of = [](auto change) {
    RunOptions options;
    change(options);
    const auto error = validate(options);
    return error ? error->field : "";
  };
  EXPECT_EQ(field_of([](RunOptions&) {}), "");
  EXPECT_EQ(field_of([](RunOptions& o) { o.beams = 1; }), "beams");
  EXPECT_EQ(field_of([](RunOptions& o) { o.field_of_view_rad = 7.0; }), "field_of_view_rad");
  EXPECT_EQ(field_of([](RunOptions& o) { o.range_max_m = 0.0; }), "range_max_m");
  EXPECT_EQ(field_of([](RunOptions& o) { o.range_noise_m = -1.0; }), "range_noise_m");
  EXPECT_EQ(field_of([](RunOptions& o) { o.drift = NAN; }), "drift");
  EXPECT_EQ(field_of([](RunOptions& o) { o.people = -1; }), "people");
  EXPECT_EQ(field_of([](RunOptions& o) { o.boxes = -1; }), "boxes");
  EXPECT_EQ(field_of([](RunOptions& o) { o.length_m = INFINITY; }), "length_m");
  EXPECT_EQ(field_of([](RunOptions& o) { o.step_m = 0.0; }), "step_m");
}

TEST(LogWriter, WritesWhatTheReaderReads) {
  RunOptions options = quiet_run();
  options.length_m = 3.0;
  RecordedLog log = simulated(box_room(), options);
  log.header.name = "a \"run\"";
  const testing::TemporaryDirectory directory;
  for (const char* name : {"run.jsonl", "run.jsonl.gz"}) {
    auto writer = LogWriter::create(directory.path() / name, log.header);
    ASSERT_TRUE(writer.ok()) << writer.error().message;
    for (const LogScan& scan : log.scans) ASSERT_TRUE(writer->write(scan).ok());
    ASSERT_TRUE(writer->close().ok());
    const auto again = read_log(directory.path() / name);
    ASSERT_TRUE(again.ok()) << again.error().message;
    EXPECT_EQ(again->header.name, log.header.name);
    EXPECT_EQ(again->header.lidar.angle_increment, log.header.lidar.angle_increment);
    ASSERT_EQ(again->scans.size(), log.scans.size());
    EXPECT_LT(distance(*again->scans.back().T_map_laser, *log.scans.back().T_map_laser), 2e-6);
    for (std::size_t beam = 0; beam < log.header.beams; ++beam) {
      const LaserScan& written = log.scans.back().scan;
      const LaserScan& read = again->scans.back().scan;
      ASSERT_EQ(read.has_return(beam), written.has_return(beam));
      if (!read.has_return(beam)) continue;
      EXPECT_NEAR(read.ranges[beam], written.ranges[beam], 6e-4);
    }
  }
}

TEST(LogWriter, SaysWhatItCannotWrite) {
  const auto writer = LogWriter::create("/nowhere/at/all.jsonl", LogHeader{});
  ASSERT_FALSE(writer.ok());
  EXPECT_EQ(writer.error().field, "/nowhere/at/all.jsonl");
}

}  // namespace
}  // namespace cornerfix::evaluation

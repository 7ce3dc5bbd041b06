#include "core/src/local_map/submap.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "core/src/scan/vfp_corners.hpp"
#include "support/floor_plans.hpp"
#include "support/matchers.hpp"
#include "support/scan_simulator.hpp"
#include "support/simulated_drive.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;
using testing::Moment;
using testing::Robot;

using std::numbers::pi;

std::vector<Point2> points_base_link(const RobotScan& scan) {
  std::vector<Point2> points = returns_as_points(scan.scan);
  for (Point2& p : points) p = scan.T_base_link_laser * p;
  return points;
}

std::vector<Feature> vfp_features_of(const LaserScan& scan) {
  return extract_vfp_corners(scan, vfp_params_for(scan.angle_increment));
}

/// Grows a submap as a robot drives; without odometry it takes the last motion for the next.
class Driver {
 public:
  explicit Driver(SubmapParams params = {}) : submap(params) {}

  void take(const RobotScan& scan) {
    Pose2 motion = last_motion_;
    double sigma = 0.15;
    if (scan.T_odom_base_link && last_odometry_) {
      motion = inverse(*last_odometry_) * *scan.T_odom_base_link;
      sigma = 0.05;
    }
    last_odometry_ = scan.T_odom_base_link;
    if (!submap.empty()) {
      const Pose2 before = pose;
      pose = submap.match(points_base_link(scan), isotropic_prior(before * motion, sigma, sigma))
                 .T_frame_base_link;
      last_motion_ = inverse(before) * pose;
    }
    if (submap.wants(pose, {})) {
      submap.keep({0, scan.scan, scan.T_base_link_laser, pose}, vfp_features_of(scan.scan));
    }
  }

  Submap submap;
  Pose2 pose;  ///< T_submap_base_link

 private:
  std::optional<Pose2> last_odometry_;
  Pose2 last_motion_;
};

struct Deviation {
  double metres = 0.0;
  double radians = 0.0;
};

/// The largest over a run, from where the robot was as seen from its start.
Deviation deviation_of(const std::vector<Moment>& moments) {
  Driver driver;
  Deviation worst;
  for (const Moment& moment : moments) {
    driver.take(moment.scan);
    const Pose2 truth = inverse(moments.front().T_map_base_link) * moment.T_map_base_link;
    worst.metres = std::max(worst.metres, distance(driver.pose, truth));
    worst.radians = std::max(worst.radians, angle_between(driver.pose, truth));
  }
  return worst;
}

Deviation deviation_in_offices(const Robot& robot) {
  return deviation_of(
      testing::drive(testing::offices(), robot, testing::drive_through_offices(), 1));
}

/// The evidence of a submap, comparable.
std::vector<std::pair<double, double>> coordinates_of(const std::vector<Point2>& points) {
  std::vector<std::pair<double, double>> result;
  for (const Point2& p : points) result.emplace_back(p.x(), p.y());
  return result;
}

std::vector<Point2> positions(const std::vector<Feature>& features) {
  std::vector<Point2> result;
  for (const Feature& feature : features) result.push_back(feature.position);
  return result;
}

std::vector<Moment> office_moments(std::size_t count) {
  std::vector<Pose2> poses = testing::drive_through_offices();
  poses.resize(std::min(count, poses.size()));
  return testing::drive(testing::offices(), {}, poses, 1);
}

TEST(Submap, FollowsTheRobotThroughRoomsWithPerfectOdometry) {
  const Deviation worst = deviation_in_offices({});
  EXPECT_LT(worst.metres, 0.10);
  EXPECT_LT(worst.radians, 0.02);
}

TEST(Submap, FollowsTheRobotWithOdometryThatIsTenPerCentOff) {
  for (const double scale : {0.9, 1.1}) {
    const Deviation worst = deviation_in_offices({.odometry_scale = scale});
    EXPECT_LT(worst.metres, 0.12) << scale;
    EXPECT_LT(worst.radians, 0.02) << scale;
  }
}

TEST(Submap, FollowsTheRobotWithoutOdometry) {
  const std::vector<Pose2> slow = testing::drive_through_offices(0.25, 0.18);
  const Deviation worst =
      deviation_of(testing::drive(testing::offices(), {.has_odometry = false}, slow, 1));
  EXPECT_LT(worst.metres, 0.15);
  EXPECT_LT(worst.radians, 0.03);
}

TEST(Submap, FollowsARobotWhoseLaserIsMountedSideways) {
  const Deviation worst = deviation_in_offices({.T_base_link_laser = {0.3, -0.1, pi / 2.0}});
  EXPECT_LT(worst.metres, 0.10);
  EXPECT_LT(worst.radians, 0.02);
}

TEST(Submap, FollowsARobotThatSeesAheadOnly) {
  const testing::Lidar lidar{.beams = 181, .field_of_view_rad = pi, .noise_m = 0.01};
  const Deviation worst = deviation_in_offices({.lidar = lidar});
  EXPECT_LT(worst.metres, 0.15);
  EXPECT_LT(worst.radians, 0.03);
}

/// Odometry is all there is along a corridor whose ends are out of sight.
TEST(Submap, KeepsOdometryAlongABareCorridor) {
  const testing::SceneBuilder corridor =
      testing::SceneBuilder().wall({0, 0}, {80, 0}).wall({0, 2}, {80, 2});
  const Point2 points[] = {{30.0, 1.0}, {42.0, 1.0}};
  const testing::Lidar lidar{.beams = 360, .range_max_m = 8.0, .noise_m = 0.01};
  const Deviation worst =
      deviation_of(testing::drive(corridor, {.lidar = lidar}, testing::route(points), 1));
  EXPECT_LT(worst.metres, 0.6);
  EXPECT_LT(worst.radians, 0.02);
}

TEST(Submap, WantsTheFirstScan) { EXPECT_TRUE(Submap().wants({}, {})); }

TEST(Submap, WantsAScanAfterAWayOrATurn) {
  const Moment first = office_moments(1).front();
  Submap submap({.keep_distance_m = 0.5, .keep_angle_rad = 0.4});
  submap.keep({0, first.scan.scan, {}, {1.0, 2.0, 3.0}}, {});
  EXPECT_FALSE(submap.wants({1.0, 2.0, 3.0}, {}));
  EXPECT_FALSE(submap.wants({1.3, 2.3, 3.2}, {}));
  EXPECT_TRUE(submap.wants({1.4, 2.4, 3.0}, {}));
  EXPECT_TRUE(submap.wants({1.0, 2.0, wrap_angle(3.45)}, {}));
}

TEST(Submap, CountsItsScans) {
  Driver driver;
  for (const Moment& moment : office_moments(12)) driver.take(moment.scan);
  const std::vector<SubmapScanPtr> scans = driver.submap.scans();
  ASSERT_GT(scans.size(), 3U);
  for (std::size_t i = 0; i < scans.size(); ++i) EXPECT_EQ(scans[i]->index, i);
  EXPECT_EQ(driver.submap.next_index(), scans.size());
  EXPECT_EQ(driver.submap.size(), scans.size());
}

TEST(Submap, ForgetsWhatLiesTooFarBack) {
  Driver driver({.window_m = 3.0});
  const std::vector<Moment> moments = office_moments(60);
  for (const Moment& moment : moments) driver.take(moment.scan);
  const std::vector<SubmapScanPtr> scans = driver.submap.scans();
  EXPECT_GT(scans.front()->index, 0U);
  double way = 0.0;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    way += distance(scans[i - 1]->T_submap_base_link, scans[i]->T_submap_base_link);
  }
  EXPECT_LE(way, 3.0);
  EXPECT_GT(way, 2.0);
}

TEST(Submap, ForgetsTheOldestOfMoreScansThanItHolds) {
  Submap submap({.max_scans = 30});
  std::mt19937_64 random(4);
  for (int i = 0; i < 100; ++i) {
    const Pose2 turned{0.0, 0.0, wrap_angle(0.3 * i)};
    submap.keep({0,
                 testing::simulate_scan(testing::figure7_room(), {.beams = 180},
                                        Pose2{6.0, 5.0, 0.0} * turned, random),
                 Pose2{}, turned},
                {});
  }
  EXPECT_EQ(submap.size(), 30U);
  EXPECT_EQ(submap.scans().front()->index, 70U);
}

/// What has been forgotten is as if it had never been seen.
TEST(Submap, AForgottenScanLeavesNoEvidenceAndNoFeature) {
  SubmapParams params;
  params.window_m = 1.0;
  const std::vector<Moment> moments = office_moments(30);
  Submap window(params);
  Submap last_only(params);
  const Pose2 T_submap_map = inverse(moments.front().T_map_base_link);
  for (const Moment& moment : moments) {
    window.keep({0, moment.scan.scan, {}, T_submap_map * moment.T_map_base_link},
                vfp_features_of(moment.scan.scan));
  }
  for (const SubmapScanPtr& scan : window.scans())
    last_only.keep(*scan, vfp_features_of(scan->scan));
  EXPECT_LT(window.size(), 10U);
  EXPECT_EQ(window.evidence().ends.size(), last_only.evidence().ends.size());
  EXPECT_EQ(window.evidence().free.size(), last_only.evidence().free.size());
  EXPECT_EQ(coordinates_of(positions(window.features())),
            coordinates_of(positions(last_only.features())));
}

TEST(Submap, EvidenceThatIsNotGatheredIsThatOfTheKeptScans) {
  SubmapParams params;
  params.window_m = 2.0;
  Driver driver(params);
  Submap other(params);
  other.stop_gathering_evidence();
  for (const Moment& moment : office_moments(60)) driver.take(moment.scan);
  for (const SubmapScanPtr& scan : driver.submap.scans())
    other.keep(*scan, vfp_features_of(scan->scan));
  const Evidence& expected = driver.submap.evidence();
  ASSERT_GT(expected.ends.size(), 100U);
  EXPECT_EQ(other.evidence().ends.size(), expected.ends.size());
  EXPECT_EQ(other.evidence().free.size(), expected.free.size());
  other.gather_evidence();
  EXPECT_EQ(other.evidence().ends.size(), expected.ends.size());
}

TEST(Submap, FeaturesAreTheCornersOfTheBuilding) {
  const std::vector<Moment> moments = office_moments(20);
  Driver driver;
  for (const Moment& moment : moments) driver.take(moment.scan);
  const Pose2 T_map_submap = moments.front().T_map_base_link;
  const std::vector<Point2> corners = testing::offices().corners();
  int known = 0;
  int repeated = 0;
  for (const Feature& feature : driver.submap.features()) {
    if (feature.count < 3) continue;
    ++repeated;
    known += std::ranges::any_of(corners, [&](const Point2& corner) {
      return (T_map_submap * feature.position - corner).norm() < 0.3;
    });
  }
  EXPECT_GT(repeated, 3);
  EXPECT_GE(known, repeated * 6 / 10);
}

TEST(Submap, EvidenceLiesOnTheWallsFarFromTheStartToo) {
  const std::vector<Moment> moments = office_moments(1000);
  Driver driver;
  for (const Moment& moment : moments) driver.take(moment.scan);
  const Pose2 T_map_submap = moments.front().T_map_base_link;
  const testing::SceneBuilder offices = testing::offices();
  int off = 0;
  for (const Point2& end : driver.submap.evidence().ends) {
    off += offices.distance_to_walls(T_map_submap * end) > 0.2 ? 1 : 0;
  }
  EXPECT_GT(driver.submap.evidence().ends.size(), 100U);
  EXPECT_LE(off, static_cast<int>(driver.submap.evidence().ends.size() / 50));
}

/// The square of the evidence moves along only when the robot is 10 m from its centre.
TEST(Submap, HoldsHitsOfTheLongestRangeBeforeItsSquareMoves) {
  const double range = EvidenceGridParams{}.max_range_m - 0.5;
  const testing::SceneBuilder walls =
      testing::SceneBuilder().wall({range, -5.0}, {range, 5.0}).wall({-5.0, range}, {5.0, range});
  const LaserScan scan = testing::simulate_scan(walls, {.beams = 720, .range_max_m = 40.0}, {});
  const Pose2 first;
  const Pose2 last{9.9, 9.9, 0.0};
  Submap submap;
  submap.keep({0, scan, {}, first}, {});
  submap.keep({1, scan, {}, last}, {});
  const auto sees = [&](const Pose2& from) {
    const auto near = [](const Point2& wanted) {
      return [wanted](const Point2& end) { return (end - wanted).norm() < 0.3; };
    };
    const std::vector<Point2> ends = submap.evidence().ends;
    return std::ranges::any_of(ends, near(from * Point2(range, 0.0))) &&
           std::ranges::any_of(ends, near(from * Point2(0.0, range)));
  };
  EXPECT_TRUE(sees(first));
  EXPECT_TRUE(sees(last));
}

/// A long way off the start the square that is kept has moved along.
TEST(Submap, MatchesAlsoFarFromItsStart) {
  testing::SceneBuilder street = testing::SceneBuilder().room({0, 0}, {70, 6});
  for (int i = 0; i < 14; ++i) street.box({3.0 + 5.0 * i, i % 3 + 0.5}, {1.0, 0.8}, 0.3 * i);
  const Point2 points[] = {{1.0, 4.5}, {66.0, 4.5}};
  const std::vector<Pose2> poses = testing::route(points, 0.5);
  const Deviation worst =
      deviation_of(testing::drive(street, {.lidar = {.beams = 120, .noise_m = 0.01}}, poses, 1));
  EXPECT_LT(worst.metres, 0.3);
}

TEST(Submap, RestoredFromItsScansIsTheSame) {
  Driver driver;
  for (const Moment& moment : office_moments(25)) driver.take(moment.scan);
  Submap restored;
  for (const SubmapScanPtr& scan : driver.submap.scans()) {
    restored.keep(*scan, vfp_features_of(scan->scan), true);
  }
  restored.set_next_index(driver.submap.next_index());
  EXPECT_EQ(coordinates_of(restored.evidence().ends),
            coordinates_of(driver.submap.evidence().ends));
  EXPECT_EQ(coordinates_of(restored.evidence().free),
            coordinates_of(driver.submap.evidence().free));
  EXPECT_EQ(coordinates_of(positions(restored.features())),
            coordinates_of(positions(driver.submap.features())));
  EXPECT_EQ(restored.next_index(), driver.submap.next_index());
  const Moment next = office_moments(26).back();
  const PosePrior prior = isotropic_prior(driver.pose, 0.2, 0.2);
  EXPECT_EQ(restored.match(points_base_link(next.scan), prior).T_frame_base_link,
            driver.submap.match(points_base_link(next.scan), prior).T_frame_base_link);
}

TEST(Submap, RestoredKeepsTheIndicesOfItsScans) {
  Driver driver({.window_m = 2.0});
  for (const Moment& moment : office_moments(40)) driver.take(moment.scan);
  Submap restored({.window_m = 2.0});
  for (const SubmapScanPtr& scan : driver.submap.scans()) restored.keep(*scan, {}, true);
  ASSERT_EQ(restored.size(), driver.submap.size());
  EXPECT_EQ(restored.scans().front()->index, driver.submap.scans().front()->index);
  EXPECT_EQ(restored.scans().back()->index, driver.submap.scans().back()->index);
}

TEST(Submap, AScanWithoutReturnsMayBeKept) {
  Submap submap;
  submap.keep({0, {}, {}, {}}, {});
  EXPECT_EQ(submap.size(), 1U);
  EXPECT_TRUE(submap.evidence().ends.empty());
  const PosePrior prior = isotropic_prior({1.0, 0.0, 0.0}, 0.1, 0.1);
  const std::vector<Point2> points{{2.0, 0.0}, {0.0, 3.0}};
  EXPECT_THAT(submap.match(points, prior).T_frame_base_link,
              IsPoseNear(prior.T_frame_base_link, 1e-6, 1e-6));
}

}  // namespace
}  // namespace cornerfix

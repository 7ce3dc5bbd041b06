#include "core/src/tracking/pose_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "support/map_maker.hpp"
#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;
using testing::SceneBuilder;

const testing::Lidar kTrackingLidar{.beams = 360, .noise_m = 0.01};

std::vector<Point2> points_seen_from(const SceneBuilder& scene, const Pose2& pose,
                                     std::mt19937_64& random) {
  return returns_as_points(testing::simulate_scan(scene, kTrackingLidar, pose, random));
}

// Of a motion that the scans constrain in all directions, and of one that only odometry measured.
const Eigen::Matrix3d kMatched = 1e-6 * Eigen::Matrix3d::Identity();
const Eigen::Matrix3d kUnmatched = 1e-2 * Eigen::Matrix3d::Identity();

SceneBuilder hall() { return SceneBuilder().room({0, 0}, {9, 6}).wall({4, 0}, {4, 2.5}); }

TEST(PoseTracker, CorrectsTheDriftOfTheWay) {
  const LocalizationMapPtr map = testing::make_map(hall(), {2.0, 4.0});
  std::mt19937_64 random(1);
  Pose2 truth{5.5, 3.0, 0.0};
  PoseTracker tracker(truth);
  for (int i = 0; i < 60; ++i) {  // round and round
    const Pose2 motion{0.1, 0.0, 0.1};
    truth = truth * motion;
    tracker.predict(motion * Pose2{0.004, 0.002, 0.002}, kMatched);
    EXPECT_EQ(tracker.update(*map, points_seen_from(hall(), truth, random), {0.0, 0.0}),
              TrackingVerdict::kFits);
  }
  EXPECT_THAT(tracker.T_map_base_link(), IsPoseNear(truth, 0.03, 0.012));
}

TEST(PoseTracker, TheOtherSidesOfKnownWallsDoNotPullThePose) {
  // The map knows the left room only. Their walls are 0.2 m thick.
  const SceneBuilder left = SceneBuilder().room({0, 0}, {6, 6});
  const SceneBuilder right = SceneBuilder().room({6.2, 0}, {9.0, 6});
  const LocalizationMapPtr map = testing::make_map(left, {3.0, 3.0});
  std::mt19937_64 random(2);
  const Pose2 truth{7.0, 3.0, 0.5};
  PoseTracker tracker(truth);
  for (int i = 0; i < 30; ++i) {
    tracker.predict({0.0, 0.0, 0.0}, kMatched);
    EXPECT_EQ(tracker.update(*map, points_seen_from(right, truth, random), {0.0, 0.0}),
              TrackingVerdict::kMisfits);
  }
  EXPECT_EQ(tracker.T_map_base_link(), truth);
}

/// A tracker after 4 m of a corridor of 30 m whose ends the lidar does not see. It ends at the
/// middle.
PoseTracker after_bare_corridor(const Eigen::Matrix3d& noise) {
  const SceneBuilder corridor = SceneBuilder().wall({-40, 0}, {40, 0}).wall({-40, 2}, {40, 2});
  const SceneBuilder mapped = SceneBuilder().room({-15, 0}, {15, 2});
  const LocalizationMapPtr map = testing::make_map(mapped, {0.0, 1.0});
  std::mt19937_64 random(3);
  Pose2 truth{-4.0, 1.0, 0.0};
  PoseTracker tracker(truth);
  for (int i = 0; i < 40; ++i) {
    truth = truth * Pose2{0.1, 0.0, 0.0};
    tracker.predict({0.1, 0.0, 0.0}, noise);
    std::vector<Point2> near;
    for (const Point2& p : points_seen_from(corridor, truth, random)) {
      if (p.norm() < 8.0) near.push_back(p);
    }
    EXPECT_EQ(tracker.update(*map, near, {0.0, 0.0}), TrackingVerdict::kFits);
  }
  return tracker;
}

TEST(PoseTracker, IsLessSureAlongABareCorridorThanAcrossIt) {
  const Eigen::Matrix3d covariance = after_bare_corridor(kMatched).covariance();
  EXPECT_GT(std::sqrt(covariance(0, 0)), 2.0 * std::sqrt(covariance(1, 1)));
}

TEST(PoseTracker, AWallDoesNotPullThePoseAlongItself) {
  const PoseTracker tracker = after_bare_corridor(Eigen::Vector3d{1e-3, 1e-6, 1e-6}.asDiagonal());
  EXPECT_GT(tracker.position_sigma_m(), 0.15);
  EXPECT_THAT(tracker.T_map_base_link(), IsPoseNear(Pose2{0.0, 1.0, 0.0}, 0.05, 0.01));
}

TEST(PoseTracker, AStepWithoutInformationDoesNotTurnThePose) {
  // Along x the match moved the pose, although the points had no information there. That of the
  // heading is tilted towards x a little, as errors of normals make it.
  const Eigen::Matrix3d prior = Eigen::Vector3d{100.0, 1e4, 2500.0}.asDiagonal();
  const Eigen::Matrix3d claimed = Eigen::Vector3d{0.0, 1e4, 15'000.0}.asDiagonal();
  Eigen::Matrix3d observed = claimed;
  observed(0, 0) = 0.375;
  observed(0, 2) = observed(2, 0) = 75.0;
  const Pose2 from{3.0, 2.0, 0.5};
  const Pose2 matched{3.009, 2.0, 0.5};
  EXPECT_THAT(moved_as_observed({from, prior}, matched, {claimed, observed}),
              IsPoseNear(from, 0.009, 0.001));
  // Where all is observed, the match is kept.
  EXPECT_THAT(moved_as_observed({from, prior}, {3.0, 2.1, 0.6}, {claimed, claimed}),
              IsPoseNear(Pose2{3.0, 2.1, 0.6}, 1e-9, 1e-9));
}

TEST(PoseTracker, IsLessSureAfterDrivingUnseenAndSurerAfterAScan) {
  const LocalizationMapPtr map = testing::make_map(hall(), {2.0, 4.0});
  std::mt19937_64 random(4);
  PoseTracker tracker({2.0, 4.0, 0.0});
  const double at_first = tracker.covariance().trace();
  tracker.predict({1.0, 0.0, 0.3}, kUnmatched);
  const double after_way = tracker.covariance().trace();
  EXPECT_GT(after_way, at_first);
  const auto points = points_seen_from(hall(), tracker.T_map_base_link(), random);
  EXPECT_EQ(tracker.update(*map, points, {0.0, 0.0}), TrackingVerdict::kFits);
  EXPECT_LT(tracker.covariance().trace(), after_way);
}

TEST(PoseTracker, ANoisyMotionWidensItsOwnDirectionOnly) {
  PoseTracker tracker({2.0, 4.0, 0.5 * std::numbers::pi});
  const Eigen::Matrix3d before = tracker.covariance();
  tracker.predict({0.0, 0.0, 0.0}, Eigen::Vector3d{0.09, 0.0, 0.0}.asDiagonal());
  const Eigen::Matrix3d after = tracker.covariance();
  EXPECT_NEAR(after(1, 1) - before(1, 1), 0.09, 1e-9);  // base_link looks along y of the map
  EXPECT_NEAR(after(0, 0), before(0, 0), 1e-9);
}

TEST(PoseTracker, FindsAPoseThatIsOffAlongItsUncertainDirection) {
  const LocalizationMapPtr map = testing::make_map(hall(), {2.0, 4.0});
  std::mt19937_64 random(6);
  const Pose2 truth{5.5, 3.0, 0.0};
  const Eigen::Matrix3d covariance = Eigen::Vector3d{0.25, 1e-4, 1e-4}.asDiagonal();
  PoseTracker tracker({6.3, 3.0, 0.0}, covariance, std::nullopt);
  tracker.predict({0.0, 0.0, 0.5}, kMatched);
  tracker.predict({0.0, 0.0, -0.5}, kMatched);
  EXPECT_EQ(tracker.update(*map, points_seen_from(hall(), truth, random), {0.0, 0.0}),
            TrackingVerdict::kFits);
  EXPECT_THAT(tracker.T_map_base_link(), IsPoseNear(truth, 0.05, 0.02));
}

TEST(PoseTracker, RepeatedScansFromOnePlaceAddLittle) {
  const LocalizationMapPtr map = testing::make_map(hall(), {2.0, 4.0});
  std::mt19937_64 random(7);
  const Pose2 truth{2.0, 4.0, 0.0};
  PoseTracker standing(truth);
  PoseTracker driving(truth);
  for (int i = 0; i < 10; ++i) {
    standing.predict({0.0, 0.0, 0.0}, Eigen::Matrix3d::Zero());
    driving.predict({0.0, 0.0, 1.0}, Eigen::Matrix3d::Zero());
    driving.predict({0.0, 0.0, -1.0}, Eigen::Matrix3d::Zero());
    const auto points = points_seen_from(hall(), truth, random);
    EXPECT_EQ(standing.update(*map, points, {0.0, 0.0}), TrackingVerdict::kFits);
    EXPECT_EQ(driving.update(*map, points, {0.0, 0.0}), TrackingVerdict::kFits);
  }
  EXPECT_GT(standing.filtered_covariance()(0, 0), driving.filtered_covariance()(0, 0));
}

TEST(PoseTracker, OdometryAloneIsLessSureThanAMatchedWay) {
  PoseTracker matched({2.0, 4.0, 0.0});
  PoseTracker alone({2.0, 4.0, 0.0});
  matched.predict({1.0, 0.0, 0.3}, kMatched);
  alone.predict({1.0, 0.0, 0.3}, kUnmatched);
  EXPECT_GT(alone.covariance().trace(), matched.covariance().trace());
}

TEST(PoseTracker, AScanWithoutReturnsSaysNothing) {
  const LocalizationMapPtr map = testing::make_map(hall(), {2.0, 4.0});
  PoseTracker tracker({2.0, 4.0, 0.0});
  EXPECT_EQ(tracker.update(*map, {}, {0.0, 0.0}), TrackingVerdict::kNoReturns);
  EXPECT_EQ(tracker.T_map_base_link(), (Pose2{2.0, 4.0, 0.0}));
}

TEST(PoseTracker, AnotherPlaceMisfits) {
  const LocalizationMapPtr map = testing::make_map(hall(), {2.0, 4.0});
  std::mt19937_64 random(5);
  PoseTracker tracker({2.0, 4.0, 0.0});
  const SceneBuilder elsewhere = SceneBuilder().room({-1.2, -1.1}, {1.3, 1.2});
  EXPECT_EQ(tracker.update(*map, points_seen_from(elsewhere, {}, random), {0.0, 0.0}),
            TrackingVerdict::kMisfits);
}

}  // namespace
}  // namespace cornerfix

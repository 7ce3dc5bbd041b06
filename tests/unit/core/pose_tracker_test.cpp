#include "core/src/pose_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "support/map_maker.hpp"
#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;
using testing::SceneBuilder;

const testing::Lidar kLidar{.beams = 360, .noise_m = 0.01};

std::vector<Point2> seen_from(const SceneBuilder& scene, const Pose2& pose,
                              std::mt19937_64& random) {
  return returns_as_points(testing::simulate_scan(scene, kLidar, pose, random));
}

SceneBuilder hall() { return SceneBuilder().room({0, 0}, {9, 6}).wall({4, 0}, {4, 2.5}); }

TEST(PoseTracker, CorrectsTheDriftOfTheWay) {
  const LocalizationMapPtr map = testing::make_map(hall(), {2.0, 4.0});
  std::mt19937_64 random(1);
  Pose2 truth{5.5, 3.0, 0.0};
  PoseTracker tracker(truth);
  for (int i = 0; i < 60; ++i) {  // round and round
    const Pose2 motion{0.1, 0.0, 0.1};
    truth = truth * motion;
    tracker.predict(motion * Pose2{0.004, 0.002, 0.002}, true);
    EXPECT_EQ(tracker.update(*map, seen_from(hall(), truth, random), {0.0, 0.0}),
              TrackingVerdict::kFits);
  }
  EXPECT_THAT(tracker.T_map_base_link(), IsPoseNear(truth, 0.03, 0.01));
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
    tracker.predict({0.0, 0.0, 0.0}, true);
    EXPECT_EQ(tracker.update(*map, seen_from(right, truth, random), {0.0, 0.0}),
              TrackingVerdict::kMisfits);
  }
  EXPECT_EQ(tracker.T_map_base_link(), truth);
}

TEST(PoseTracker, IsLessSureAlongABareCorridorThanAcrossIt) {
  const SceneBuilder corridor = SceneBuilder().wall({-40, 0}, {40, 0}).wall({-40, 2}, {40, 2});
  const SceneBuilder mapped = SceneBuilder().room({-15, 0}, {15, 2});
  const LocalizationMapPtr map = testing::make_map(mapped, {0.0, 1.0});
  std::mt19937_64 random(3);
  Pose2 truth{-4.0, 1.0, 0.0};
  PoseTracker tracker(truth);
  for (int i = 0; i < 40; ++i) {
    truth = truth * Pose2{0.1, 0.0, 0.0};
    tracker.predict({0.1, 0.0, 0.0}, true);
    std::vector<Point2> near;
    for (const Point2& p : seen_from(corridor, truth, random)) {
      if (p.norm() < 8.0) near.push_back(p);
    }
    EXPECT_EQ(tracker.update(*map, near, {0.0, 0.0}), TrackingVerdict::kFits);
  }
  const Eigen::Matrix3d covariance = tracker.covariance();
  EXPECT_GT(std::sqrt(covariance(0, 0)), 2.0 * std::sqrt(covariance(1, 1)));
}

TEST(PoseTracker, IsLessSureAfterDrivingUnseenAndSurerAfterAScan) {
  const LocalizationMapPtr map = testing::make_map(hall(), {2.0, 4.0});
  std::mt19937_64 random(4);
  PoseTracker tracker({2.0, 4.0, 0.0});
  const double at_first = tracker.covariance().trace();
  tracker.predict({1.0, 0.0, 0.3}, false);
  const double after_way = tracker.covariance().trace();
  EXPECT_GT(after_way, at_first);
  const auto points = seen_from(hall(), tracker.T_map_base_link(), random);
  EXPECT_EQ(tracker.update(*map, points, {0.0, 0.0}), TrackingVerdict::kFits);
  EXPECT_LT(tracker.covariance().trace(), after_way);
}

TEST(PoseTracker, OdometryAloneIsLessSureThanAMatchedWay) {
  PoseTracker matched({2.0, 4.0, 0.0});
  PoseTracker alone({2.0, 4.0, 0.0});
  matched.predict({1.0, 0.0, 0.3}, true);
  alone.predict({1.0, 0.0, 0.3}, false);
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
  EXPECT_EQ(tracker.update(*map, seen_from(elsewhere, {}, random), {0.0, 0.0}),
            TrackingVerdict::kMisfits);
}

}  // namespace
}  // namespace cornerfix

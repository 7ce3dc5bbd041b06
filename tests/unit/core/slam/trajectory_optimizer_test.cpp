#include <gtest/gtest.h>

#include <cornerfix/slam.hpp>

#include "support/matchers.hpp"
#include "support/simulated_drive.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;
using testing::SceneBuilder;

/// A corridor around a block, no stretch of it like another.
SceneBuilder ring() {
  return SceneBuilder()
      .room({0, 0}, {18, 14})
      .room({3, 3}, {15, 11})
      .box({5.0, 0.3}, {1.2, 0.6})
      .box({9.0, 2.6}, {0.8, 0.8}, 0.3)
      .box({12.0, 0.5}, {0.7, 1.0}, 0.2)
      .box({17.6, 4.0}, {0.8, 1.4})
      .box({15.3, 8.0}, {0.6, 0.9}, 0.5)
      .box({17.5, 12.0}, {1.0, 0.6})
      .box({11.0, 13.6}, {1.6, 0.8})
      .box({7.0, 11.4}, {0.9, 0.8}, 0.4)
      .box({4.0, 13.5}, {0.7, 1.0})
      .box({0.4, 9.0}, {0.8, 1.0}, 0.1)
      .box({2.6, 6.0}, {0.8, 1.5});
}

struct Drive {
  std::vector<Pose2> truth;         ///< In the frame of the first pose.
  std::vector<PosedScan> drifting;  ///< At poses that turn too much.
};

/// One and a half rounds; a turn of `turn_per_step` is added at each step of 0.3 m.
Drive drive_around(double turn_per_step) {
  const Point2 corners[] = {{1.5, 1.5}, {16.5, 1.5}, {16.5, 12.5}, {1.5, 12.5},
                            {1.5, 1.5}, {16.5, 1.5}, {16.5, 12.5}};
  const std::vector<Pose2> poses = testing::route(corners, 0.3, 0.3);
  const auto moments = testing::drive(ring(), {.lidar = {.beams = 120, .noise_m = 0.01}}, poses, 7);
  Drive drive;
  Pose2 T_drive_scan;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i > 0) T_drive_scan = T_drive_scan * inverse(poses[i - 1]) * poses[i];
    if (i > 0) T_drive_scan.yaw = wrap_angle(T_drive_scan.yaw + turn_per_step);
    drive.truth.push_back(inverse(poses.front()) * poses[i]);
    drive.drifting.push_back({moments[i].scan.scan, {}, T_drive_scan});
  }
  return drive;
}

/// Made once: the simulation takes longer than what is tested.
const Drive& drifting_drive() {
  static const Drive drive = drive_around(0.0008);
  return drive;
}
const Drive& true_drive() {
  static const Drive drive = drive_around(0.0);
  return drive;
}

TEST(TrajectoryOptimizer, TakesTheDriftAway) {
  const Drive& drive = drifting_drive();
  ASSERT_GT(distance(drive.drifting.back().T_map_base_link, drive.truth.back()), 1.0);
  const auto optimized = optimize_trajectory(drive.drifting);
  ASSERT_TRUE(optimized);
  EXPECT_GE(optimized->loop_closures, 3U);
  ASSERT_EQ(optimized->T_map_base_link.size(), drive.truth.size());
  for (std::size_t i = 0; i < drive.truth.size(); ++i)
    ASSERT_THAT(optimized->T_map_base_link[i], IsPoseNear(drive.truth[i], 0.25, 0.03)) << i;
}

TEST(TrajectoryOptimizer, LeavesATrueTrajectoryAsItIs) {
  const Drive& drive = true_drive();
  const auto optimized = optimize_trajectory(drive.drifting);
  ASSERT_TRUE(optimized);
  for (std::size_t i = 0; i < drive.truth.size(); ++i)
    ASSERT_THAT(optimized->T_map_base_link[i], IsPoseNear(drive.truth[i], 0.06, 0.01)) << i;
}

TEST(TrajectoryOptimizer, ClosesNoLoopOnNewGround) {
  const Drive& drive = true_drive();
  const std::span<const PosedScan> way_there = std::span(drive.drifting).first(100);
  const auto optimized = optimize_trajectory(way_there);
  ASSERT_TRUE(optimized);
  EXPECT_EQ(optimized->loop_closures, 0U);
}

TEST(TrajectoryOptimizer, GivesTheSameTwice) {
  const auto part = std::span(drifting_drive().drifting).first(120);
  EXPECT_EQ(optimize_trajectory(part)->T_map_base_link, optimize_trajectory(part)->T_map_base_link);
}

TEST(TrajectoryOptimizer, TellsItsProgressUpToTheEnd) {
  const Drive& drive = true_drive();
  std::vector<double> shares;
  ASSERT_TRUE(optimize_trajectory(std::span(drive.drifting).first(60), [&](double share) {
    shares.push_back(share);
    return true;
  }));
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_EQ(shares.back(), 1.0);
}

TEST(TrajectoryOptimizer, IsGivenUpAtAnyStage) {
  const auto part = std::span(true_drive().drifting).first(60);
  for (const double end : {0.0, 0.5, 0.7, 1.0}) {
    const auto left = optimize_trajectory(part, [end](double share) { return share < end; });
    ASSERT_FALSE(left) << end;
    EXPECT_EQ(left.error().code, ErrorCode::kUnavailable);
  }
}

TEST(TrajectoryOptimizer, TakesADriveOfOneKeyFrameOrNone) {
  EXPECT_TRUE(optimize_trajectory({})->T_map_base_link.empty());
  const Drive& drive = true_drive();
  const auto optimized = optimize_trajectory(std::span(drive.drifting).first(1));
  ASSERT_TRUE(optimized);
  EXPECT_THAT(optimized->T_map_base_link, ::testing::ElementsAre(Pose2{}));
}

}  // namespace
}  // namespace cornerfix

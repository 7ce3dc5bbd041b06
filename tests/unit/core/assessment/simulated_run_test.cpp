#include "core/src/assessment/simulated_run.hpp"

#include <gtest/gtest.h>

#include "support/drawn_grid.hpp"

namespace cornerfix {
namespace {

using testing::SceneBuilder;

OccupancyGrid floor_of(const SceneBuilder& scene, const Point2& inside) {
  return testing::drawn_grid(scene, inside, {-1.0, -1.0, 0.0}, {14.0, 8.0}, 0.05);
}

double path_length(const std::vector<Pose2>& poses) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < poses.size(); ++i) length_m += distance(poses[i - 1], poses[i]);
  return length_m;
}

TEST(SimulatedRun, GoesStraightWhereThereIsRoom) {
  const OccupancyGrid floor = floor_of(SceneBuilder().room({0, 0}, {12, 6}), {3.0, 3.0});
  const std::vector<Pose2> poses = simulated_run(SimulatedLidar(floor), {2.0, 3.0, 0.0}, 4.0);
  ASSERT_EQ(poses.size(), 9U);
  for (std::size_t i = 0; i < poses.size(); ++i)
    EXPECT_NEAR(distance(poses[i], {2.0 + 0.5 * static_cast<double>(i), 3.0, 0.0}), 0.0, 1e-9);
}

TEST(SimulatedRun, TurnsAsideBeforeAWallAndDrivesOn) {
  const SceneBuilder room = SceneBuilder().room({0, 0}, {6, 6});
  const OccupancyGrid floor = floor_of(room, {3.0, 3.0});
  const std::vector<Pose2> poses = simulated_run(SimulatedLidar(floor), {3.0, 3.0, 0.3}, 20.0);
  EXPECT_NEAR(path_length(poses), 20.0, 0.5);
  for (const Pose2& pose : poses) EXPECT_GE(room.distance_to_walls(pose.translation()), 0.2);
}

TEST(SimulatedRun, StaysWhereTheRobotIsShutIn) {
  const OccupancyGrid floor = floor_of(SceneBuilder().room({0, 0}, {0.7, 0.7}), {0.35, 0.35});
  const std::vector<Pose2> poses = simulated_run(SimulatedLidar(floor), {0.35, 0.35, 0.0}, 10.0);
  EXPECT_EQ(poses.size(), 1U);
}

}  // namespace
}  // namespace cornerfix

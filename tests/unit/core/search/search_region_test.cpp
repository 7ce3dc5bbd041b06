#include "core/src/search/search_region.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "support/mapped_floor.hpp"

namespace cornerfix {
namespace {

using std::numbers::pi;
const StartRegion kDock{.map = "floor", .center = {2.0, 1.0}, .radius_m = 1.0};

StartRegion dock_with_heading(double yaw, double tolerance_rad) {
  StartRegion region = kDock;
  region.yaw = yaw;
  region.yaw_tolerance_rad = tolerance_rad;
  return region;
}

TEST(SearchRegion, IsACircleInOneMapOrInAny) {
  const LocalizationMap floor("floor", 1, {});
  const LocalizationMap other("other", 1, {});
  EXPECT_TRUE(SearchRegion(kDock).is_in(floor));
  EXPECT_FALSE(SearchRegion(kDock).is_in(other));
  EXPECT_TRUE(SearchRegion({.radius_m = 1.0}).is_in(other));
  EXPECT_TRUE(SearchRegion(kDock).contains({2.0, 1.99, 3.0}));
  EXPECT_FALSE(SearchRegion(kDock).contains({2.0, 2.01, 3.0}));
  EXPECT_TRUE(SearchRegion(kDock).contains({2.0, 2.01, 3.0}, 0.02));
}

TEST(SearchRegion, LeavesHeadingsWithinTheTolerance) {
  const SearchRegion region(dock_with_heading(pi, 0.3));
  EXPECT_TRUE(region.contains({2.0, 1.0, -pi + 0.29}));
  EXPECT_FALSE(region.contains({2.0, 1.0, -pi + 0.31}));
  EXPECT_TRUE(region.contains({2.0, 1.0, -pi + 0.31}, 0.0, 0.02));
}

TEST(SearchRegion, MovesWithTheRobot) {
  SearchRegion region(dock_with_heading(0.5, 0.2));
  const Pose2 T_map_start{2.0, 1.0, 0.5};
  const Pose2 motion{3.0, 1.0, 1.2};
  region.move_along(motion);
  EXPECT_TRUE(region.contains(T_map_start * motion));
  EXPECT_FALSE(region.contains(T_map_start)) << "the robot has left";
  EXPECT_FALSE(region.contains(Pose2{3.3, 1.0, 0.5} * motion)) << "it began outside";
}

TEST(SearchRegion, OfAHeadingUnknownMovesToARing) {
  SearchRegion region(kDock);
  const Pose2 motion{5.0, 0.0, 0.0};
  region.move_along(motion);
  for (const double yaw : {0.0, 2.0, -2.5}) {
    EXPECT_TRUE(region.contains(Pose2{2.0, 1.0, yaw} * motion)) << yaw;
    EXPECT_FALSE(region.contains({2.0, 1.0, yaw})) << yaw;
  }
}

TEST(SearchRegion, AMirroredOneBeganAtTheSamePlace) {
  SearchRegion region(dock_with_heading(0.5, 0.2));
  const Pose2 T_map_start{2.0, 1.0, 0.5};
  region.move_along({3.0, 1.0, 1.2});
  EXPECT_TRUE(region.mirrored().contains(T_map_start * Pose2{3.0, -1.0, -1.2}));
  EXPECT_FALSE(region.mirrored().contains(T_map_start * Pose2{3.0, 1.0, 1.2}));
}

TEST(SearchRegion, CountsItsKnownFreeSpace) {
  const LocalizationMapPtr map = testing::mapped_floor(
      testing::SceneBuilder().room({0, 0}, {10, 10}), {{5.0, 5.0}}, {10.0, 10.0});
  const StartRegion inside{.center = {5.0, 5.0}, .radius_m = 2.0};
  EXPECT_NEAR(SearchRegion(inside).free_area_m2(*map), 4.0 * pi, 0.3);
  const StartRegion at_the_wall{.center = {0.0, 5.0}, .radius_m = 2.0};
  EXPECT_NEAR(SearchRegion(at_the_wall).free_area_m2(*map), 2.0 * pi, 0.4);
  const StartRegion everywhere{.center = {5.0, 5.0}, .radius_m = 1e5};
  EXPECT_DOUBLE_EQ(SearchRegion(everywhere).free_area_m2(*map), map->free_area_m2());
  const StartRegion elsewhere{.map = "other", .center = {5.0, 5.0}, .radius_m = 2.0};
  EXPECT_EQ(SearchRegion(elsewhere).free_area_m2(*map), 0.0);
  const StartRegion one_way{
      .center = {5.0, 5.0}, .radius_m = 2.0, .yaw = 0.0, .yaw_tolerance_rad = pi / 4.0};
  EXPECT_NEAR(SearchRegion(one_way).free_area_m2(*map), pi, 0.1) << "a quarter of the headings";
}

TEST(StartRegion, ErrorsNameTheField) {
  EXPECT_FALSE(validate(kDock).has_value());
  StartRegion region = kDock;
  region.radius_m = 0.0;
  EXPECT_EQ(validate(region)->field, "radius_m");
  region = dock_with_heading(0.0, 4.0);
  EXPECT_EQ(validate(region)->field, "yaw_tolerance_rad");
}

}  // namespace
}  // namespace cornerfix

#include <gtest/gtest.h>

#include <random>

#include "core/src/acceptance/acceptance.hpp"
#include "core/src/search/map_index.hpp"
#include "support/map_maker.hpp"

namespace cornerfix {
namespace {

using testing::SceneBuilder;

/// A hall of 30 m x 20 m with four columns of 0.6 m about `centre`.
SceneBuilder hall(const Point2& centre, double spacing_m) {
  SceneBuilder scene = SceneBuilder().room({0.0, 0.0}, {30.0, 20.0});
  for (const double x : {-spacing_m, spacing_m}) {
    for (const double y : {-spacing_m, spacing_m}) {
      const Point2 column = centre + Point2(x, y);
      scene.room(column - Point2(0.3, 0.3), column + Point2(0.3, 0.3));
    }
  }
  return scene;
}

/// With a range that reaches two of the walls only.
Evidence seen_in(const SceneBuilder& scene) {
  EvidenceGrid grid;
  std::mt19937_64 random(1);
  const testing::Lidar lidar{.beams = 720, .range_max_m = 12.0, .noise_m = 0.01};
  for (const Pose2& pose : {Pose2{7.0, 7.0, 0.0}, Pose2{8.0, 6.0, 1.0}, Pose2{6.0, 5.0, 2.0}})
    grid.add(testing::simulate_scan(scene, lidar, pose, random), pose);
  return grid.collect();
}

const Point2 kCentre{7.2, 6.4};
const SceneBuilder kEmptyHall = SceneBuilder().room({0.0, 0.0}, {30.0, 20.0});
const LocalizationMapPtr kMap = testing::make_map(hall(kCentre, 3.5), {15.0, 10.0});

TEST(TwoLines, APoseThatExplainsTheColumnsTooIsAcceptable) {
  EXPECT_TRUE(
      explains_more_than_two_lines(kMap->index().classes, seen_in(hall(kCentre, 3.5)), Pose2{}));
}

TEST(TwoLines, TwoWallsAloneMayBeThoseOfAnotherHall) {
  EXPECT_FALSE(
      explains_more_than_two_lines(kMap->index().classes, seen_in(hall({6.0, 5.0}, 2.0)), Pose2{}));
}

TEST(TwoLines, NothingElseThanTwoWallsIsNoContradiction) {
  const LocalizationMapPtr empty = testing::make_map(kEmptyHall, {15.0, 10.0});
  EXPECT_TRUE(explains_more_than_two_lines(empty->index().classes, seen_in(kEmptyHall), Pose2{}));
}

TEST(TwoLines, WallsSeenThroughMappedColumnsContradict) {
  EXPECT_FALSE(explains_more_than_two_lines(kMap->index().classes, seen_in(kEmptyHall), Pose2{}));
}

}  // namespace
}  // namespace cornerfix

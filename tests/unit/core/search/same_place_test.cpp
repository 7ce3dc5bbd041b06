#include "core/src/search/same_place.hpp"

#include <gtest/gtest.h>

#include "support/drawn_grid.hpp"
#include "support/matchers.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;

TEST(SamePlace, IsNearInPositionAndHeading) {
  const Pose2 here{3.0, 4.0, 3.1};
  EXPECT_TRUE(is_same_place(here, {3.6, 4.6, -3.1}));
  EXPECT_FALSE(is_same_place(here, {4.1, 4.0, 3.1})) << "more than a metre away";
  EXPECT_FALSE(is_same_place(here, {3.0, 4.0, 2.8})) << "turned by 0.3 rad";
}

TEST(SamePlace, RefinementLeadsFromACellOfTheSearchToThePose) {
  const auto scene = testing::SceneBuilder().room({0, 0}, {6, 4}).box({4.5, 1.0}, {0.8, 1.1}, 0.4);
  const DistanceField field(
      testing::drawn_grid(scene, {1.0, 1.0}, {-1.0, -1.0, 0.0}, {8.0, 6.0}, 0.05));
  const Pose2 truth{2.0, 2.2, 0.6};
  const auto points = returns_as_points(testing::simulate_scan(scene, {.beams = 360}, truth));
  EXPECT_THAT(refined_coarse_to_fine(field, points, truth * Pose2{0.25, -0.2, 0.1}),
              IsPoseNear(truth, 0.05, 0.01));
}

}  // namespace
}  // namespace cornerfix

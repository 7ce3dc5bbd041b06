#include "core/src/base/within.hpp"

#include <gmock/gmock.h>

namespace cornerfix {
namespace {

TEST(Within, KeepsPointsUpToTheRadiusInTheirOrder) {
  const std::vector<Point2> points{{3.0, 0.0}, {0.0, -2.0}, {1.0, 0.0}, {1.5, 1.5}};
  EXPECT_THAT(within(points, 2.0), ::testing::ElementsAre(Point2(0.0, -2.0), Point2(1.0, 0.0)));
}

TEST(Within, KeepsNothingOfNothing) { EXPECT_TRUE(within({}, 1.0).empty()); }

}  // namespace
}  // namespace cornerfix

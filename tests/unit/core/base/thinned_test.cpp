#include "core/src/base/thinned.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cornerfix {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<double> x_of(const std::vector<Point2>& points) {
  std::vector<double> x;
  for (const Point2& point : points) x.push_back(point.x());
  return x;
}

std::vector<Point2> row(int count) {
  std::vector<Point2> points;
  for (int i = 0; i < count; ++i) points.emplace_back(i, 0.0);
  return points;
}

TEST(Thinned, KeepsEvenlySpacedPointsInTheirOrder) {
  EXPECT_THAT(x_of(thinned(row(10), 5)), ElementsAre(0, 2, 4, 6, 8));
}

TEST(Thinned, KeepsAllOfFewPoints) { EXPECT_THAT(x_of(thinned(row(3), 5)), ElementsAre(0, 1, 2)); }

TEST(Thinned, IsEmptyForNoPointsAndForACountOfZero) {
  EXPECT_THAT(thinned({}, 5), IsEmpty());
  EXPECT_THAT(thinned(row(3), 0), IsEmpty());
}

}  // namespace
}  // namespace cornerfix

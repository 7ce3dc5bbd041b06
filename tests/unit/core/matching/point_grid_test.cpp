#include "core/src/matching/point_grid.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace cornerfix {
namespace {

std::vector<Point2> random_points(std::size_t count) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> coordinate(-20.0, 30.0);
  std::vector<Point2> points(count);
  for (Point2& point : points) point = {coordinate(random), coordinate(random)};
  return points;
}

TEST(PointGrid, VisitsEachPointWithinTheRadiusOnce) {
  const std::vector<Point2> points = random_points(400);
  const PointGrid grid(points, 0.15);
  ASSERT_EQ(grid.points().size(), points.size());
  for (const Point2& center : {Point2(0.0, 0.0), Point2(-20.0, 30.0), Point2(12.3, -7.0)}) {
    std::vector<double> visited;
    grid.for_each_within(center, 6.0, [&](std::uint32_t index, double squared_distance) {
      EXPECT_DOUBLE_EQ((grid.points()[index] - center).squaredNorm(), squared_distance);
      visited.push_back(squared_distance);
    });
    std::vector<double> expected;
    for (const Point2& point : points) {
      if ((point - center).squaredNorm() <= 36.0)
        expected.push_back((point - center).squaredNorm());
    }
    EXPECT_FALSE(expected.empty());
    EXPECT_THAT(visited, ::testing::UnorderedElementsAreArray(expected));
  }
}

TEST(PointGrid, FindsTheNearestPointWithinTheTolerance) {
  const std::vector<Point2> points{{0.0, 0.0}, {0.2, 0.0}, {5.0, 5.0}};
  const PointGrid grid(points, 0.15);
  EXPECT_EQ(grid.nearest({0.14, 0.0}), Point2(0.2, 0.0));
  EXPECT_EQ(grid.nearest({5.0, 5.1}), Point2(5.0, 5.0));
  EXPECT_FALSE(grid.nearest({5.0, 5.2}));
  EXPECT_FALSE(grid.nearest({-100.0, 0.0}));
}

TEST(PointGrid, OfNoPointsFindsNothing) {
  const PointGrid grid({}, 0.15);
  EXPECT_FALSE(grid.nearest({0.0, 0.0}));
  grid.for_each_within({0.0, 0.0}, 10.0,
                       [](std::uint32_t, double) { FAIL() << "there is no point"; });
}

}  // namespace
}  // namespace cornerfix

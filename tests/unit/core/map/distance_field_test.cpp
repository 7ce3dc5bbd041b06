#include "core/src/map/distance_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "support/drawn_grid.hpp"

namespace cornerfix {
namespace {

using std::numbers::pi;
constexpr double kRounding = 0.5 * DistanceField::kStep + 1e-6;

/// 1.2 x 0.85 m with a wall in every 20th cell or so.
OccupancyGrid random_grid(std::uint64_t seed, double resolution = 0.05) {
  OccupancyGrid grid =
      testing::unknown_grid({-1.0, 2.0, 0.0}, {24 * resolution, 17 * resolution}, resolution);
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> die(0, 39);
  for (Cell& cell : grid.cells) {
    const int roll = die(random);
    cell = roll < 2 ? Cell::kOccupied : roll < 20 ? Cell::kFree : Cell::kUnknown;
  }
  grid.cells.front() = Cell::kOccupied;
  return grid;
}

std::vector<Point2> wall_centers(const OccupancyGrid& grid) {
  std::vector<Point2> centers;
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      if (grid.at({column, row}) == Cell::kOccupied) centers.push_back(grid.center({column, row}));
    }
  }
  return centers;
}

double nearest_of(const std::vector<Point2>& centers, const Point2& p) {
  double nearest = DistanceField::kMaxDistance;
  for (const Point2& center : centers) nearest = std::min(nearest, (center - p).norm());
  return nearest;
}

OccupancyGrid one_wall_cell() {
  OccupancyGrid grid = testing::unknown_grid({}, {6.0, 6.0}, 0.1);
  grid.cells[grid.offset({30, 30})] = Cell::kOccupied;
  return grid;
}

TEST(DistanceField, MeasuresWhatBruteForceMeasures) {
  for (const double resolution : {0.02, 0.05, 0.11, 0.3}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const OccupancyGrid grid = random_grid(seed, resolution);
      const std::vector<Point2> walls = wall_centers(grid);
      const DistanceField field(grid);
      for (int row = 0; row < grid.height; ++row) {
        for (int column = 0; column < grid.width; ++column) {
          const Point2 center = grid.center({column, row});
          ASSERT_NEAR(field.nearest(center), nearest_of(walls, center), kRounding)
              << "seed " << seed << ", " << resolution << " m/cell, cell " << column << ", " << row;
        }
      }
    }
  }
}

/// Wide maps are measured in parts: what lies on both sides of a seam is seen from either.
TEST(DistanceField, MeasuresAWideGridAsItMeasuresItsParts) {
  constexpr double kResolution = 0.1;
  std::mt19937_64 random(5);
  std::bernoulli_distribution is_wall(0.003);
  OccupancyGrid wide = testing::unknown_grid({}, {900.0, 3.0}, kResolution);
  for (Cell& cell : wide.cells) cell = is_wall(random) ? Cell::kOccupied : Cell::kFree;
  for (int column = 2500; column < 3500; ++column) {
    for (int row = 0; row < wide.height; ++row)
      wide.cells[wide.offset({column, row})] = Cell::kFree;
  }
  const DistanceField field(wide);
  for (const int first : {0, 1900, 2400, 4000, 6100, 8500}) {
    const int columns = std::min(600, wide.width - first);
    OccupancyGrid part = testing::unknown_grid({}, {kResolution * columns, 3.0}, kResolution);
    for (int row = 0; row < part.height; ++row) {
      for (int column = 0; column < columns; ++column)
        part.cells[part.offset({column, row})] = wide.at({first + column, row});
    }
    const DistanceField expected(part);
    for (int row = 0; row < part.height; ++row) {
      for (int column = 30; column + 30 < columns; ++column) {
        ASSERT_EQ(field.steps()[wide.offset({first + column, row})],
                  expected.steps()[part.offset({column, row})])
            << "column " << first + column << ", row " << row;
      }
    }
  }
}

TEST(DistanceField, NearestIsFarHoweverFarOutside) {
  const DistanceField field(random_grid(3));
  for (const double far : {-1e-9, -3e9, 3e9, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(field.nearest({far, 0.5}), DistanceField::kMaxDistance) << far;
    EXPECT_EQ(field.nearest({0.5, far}), DistanceField::kMaxDistance) << far;
  }
}

TEST(DistanceField, IsFarEverywhereWithoutWalls) {
  const DistanceField field(testing::unknown_grid({}, {1.0, 1.0}, 0.1));
  for (const std::uint8_t steps : field.steps()) EXPECT_EQ(steps, 255);
}

TEST(DistanceField, OfAnEmptyGridIsFarEverywhere) {
  const DistanceField field{OccupancyGrid{}};
  EXPECT_DOUBLE_EQ(field.sample({0.0, 0.0}).distance, DistanceField::kMaxDistance);
  EXPECT_DOUBLE_EQ(field.nearest({0.0, 0.0}), DistanceField::kMaxDistance);
}

TEST(DistanceField, IsCappedFarFromWalls) {
  const DistanceField field(one_wall_cell());
  EXPECT_NEAR(field.nearest({3.05 + 2.5, 3.05}), 2.5, kRounding);
  EXPECT_DOUBLE_EQ(field.nearest({3.05 + 2.7, 3.05}), DistanceField::kMaxDistance);
}

TEST(DistanceField, SamplesTheCellsThemselvesAtTheirCenters) {
  const OccupancyGrid grid = random_grid(3);
  const DistanceField field(grid);
  for (int row = 0; row + 1 < grid.height; ++row) {
    for (int column = 0; column + 1 < grid.width; ++column) {
      const Point2 center = grid.center({column, row}) + Point2(1e-9, 1e-9);
      EXPECT_NEAR(field.sample(center).distance, field.nearest(center), 1e-6);
    }
  }
}

TEST(DistanceField, SamplesTheWeightedMeanBetweenCenters) {
  const OccupancyGrid grid = random_grid(4);
  const DistanceField field(grid);
  const Point2 low = grid.center({7, 9});
  const auto at = [&](int column, int row) { return field.nearest(grid.center({column, row})); };
  const Point2 between = low + grid.resolution * Point2(0.25, 0.6);
  const double expected =
      0.4 * (0.75 * at(7, 9) + 0.25 * at(8, 9)) + 0.6 * (0.75 * at(7, 10) + 0.25 * at(8, 10));
  EXPECT_NEAR(field.sample(between).distance, expected, 1e-9);
}

TEST(DistanceField, GradientIsTheSlopeOfTheSamples) {
  const DistanceField field(random_grid(5));
  std::mt19937_64 random(5);
  std::uniform_int_distribution<int> column(0, 22), row(0, 15);
  std::uniform_real_distribution<double> share(0.1, 0.9);
  constexpr double kSmall = 1e-6;
  for (int i = 0; i < 200; ++i) {
    const Point2 p =
        0.05 * Point2(column(random) + 0.5 + share(random), row(random) + 0.5 + share(random));
    const Point2 dx(kSmall, 0.0), dy(0.0, kSmall);
    const Point2 slope((field.sample(p + dx).distance - field.sample(p - dx).distance),
                       (field.sample(p + dy).distance - field.sample(p - dy).distance));
    EXPECT_LT((field.sample(p).gradient - slope / (2.0 * kSmall)).norm(), 1e-6) << p.transpose();
  }
}

TEST(DistanceField, GradientPointsAwayFromTheWallAtUnitSlope) {
  const DistanceField field(one_wall_cell());
  const Point2 wall(3.05, 3.05);
  for (int i = 0; i < 32; ++i) {
    const Point2 away(std::cos(i * pi / 16.0), std::sin(i * pi / 16.0));
    const Point2 gradient = field.sample(wall + 1.5 * away).gradient;
    EXPECT_GT(gradient.dot(away), 0.9) << away.transpose();
    EXPECT_LT(gradient.norm(), 1.1) << away.transpose();
  }
}

TEST(DistanceField, IsFarAndFlatOutside) {
  OccupancyGrid grid = testing::unknown_grid({5.0, 5.0, 0.0}, {1.0, 0.5}, 0.1);
  std::fill(grid.cells.begin(), grid.cells.end(), Cell::kOccupied);
  const DistanceField field(grid);
  const Point2 outside[] = {{-0.01, 0.25}, {1.01, 0.25}, {0.5, -0.01}, {0.5, 0.51},
                            {-1e6, 0.25},  {1e6, 0.25},  {0.5, -1e6},  {0.5, 1e6}};
  for (const Point2& p : outside) {
    EXPECT_DOUBLE_EQ(field.nearest(p), DistanceField::kMaxDistance) << p.transpose();
    EXPECT_DOUBLE_EQ(field.sample(p).distance, DistanceField::kMaxDistance) << p.transpose();
    EXPECT_EQ(field.sample(p).gradient, Point2(0.0, 0.0)) << p.transpose();
  }
}

TEST(DistanceField, StampedWithTheWallsIsTheTransform) {
  const OccupancyGrid grid = random_grid(6);
  const DistanceField transformed(grid);
  DistanceField stamped(grid.T_map_grid, grid.resolution, grid.width, grid.height);
  stamped.stamp(wall_centers(grid), 3.0);
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    EXPECT_NEAR(stamped.steps()[i], transformed.steps()[i], 1) << "cell " << i;
  }
}

TEST(DistanceField, StampMeasuresFromAPointBetweenCenters) {
  DistanceField field({}, 0.1, 30, 30);
  const Point2 wall(1.53, 1.48);
  field.stamp(std::vector{wall}, 1.0);
  for (const Point2& center : {Point2(1.55, 1.45), Point2(2.05, 1.95), Point2(1.05, 1.45)}) {
    EXPECT_NEAR(field.nearest(center), (center - wall).norm(), DistanceField::kStep);
  }
}

TEST(DistanceField, StampReachesAsFarAsItsRadius) {
  DistanceField field({}, 0.1, 60, 60);
  field.stamp(std::vector{Point2(3.05, 3.05)}, 0.5);
  EXPECT_LT(field.nearest({3.45, 3.05}), 0.45);
  EXPECT_DOUBLE_EQ(field.nearest({4.05, 3.05}), DistanceField::kMaxDistance);
}

TEST(DistanceField, StampNeverRaisesADistance) {
  DistanceField field({}, 0.1, 20, 20);
  field.stamp(std::vector{Point2(1.0, 1.0)}, 1.0);
  const std::vector<std::uint8_t> before(field.steps().begin(), field.steps().end());
  field.stamp(std::vector{Point2(1.3, 1.1)}, 1.0);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_LE(field.steps()[i], before[i]);
}

TEST(DistanceField, StampsOnAndBeyondTheBorderAreCutOff) {
  DistanceField field({}, 0.1, 10, 10);
  for (const Point2& p : {Point2(0.0, 0.0), Point2(-0.3, 0.5), Point2(1.0, 1.0), Point2(0.5, 1.2),
                          Point2(-50.0, 0.5), Point2(0.5, 50.0)}) {
    field.stamp(std::vector{p}, 0.5);
  }
  EXPECT_NEAR(field.nearest({0.05, 0.05}), std::hypot(0.05, 0.05), DistanceField::kStep);
  EXPECT_NEAR(field.nearest({0.05, 0.55}), std::hypot(0.35, 0.05), DistanceField::kStep);
  EXPECT_NEAR(field.nearest({0.55, 0.95}), std::hypot(0.05, 0.25), DistanceField::kStep);
}

/// A map_server yaml may turn the image: what lies at a place of the map stays there.
TEST(DistanceField, OfATurnedGridTellsTheSameOfTheMap) {
  const testing::SceneBuilder scene = testing::SceneBuilder().box({2.0, 1.5}, {1.0, 0.6}, 0.4);
  const DistanceField straight(
      testing::drawn_grid(scene, {0.5, 0.5}, {0.0, 0.0, 0.0}, {4.0, 3.0}, 0.02));
  for (const double yaw : {3.14, -3.14, pi / 2.0, 0.5}) {
    const Pose2 T_map_grid = Pose2{2.0, 1.5, yaw} * Pose2{-3.0, -3.0, 0.0};
    const DistanceField turned(
        testing::drawn_grid(scene, {0.5, 0.5}, T_map_grid, {6.0, 6.0}, 0.02));
    for (const Point2& p : {Point2(0.7, 0.8), Point2(2.0, 2.4), Point2(3.1, 1.2)}) {
      EXPECT_NEAR(turned.sample(turned.T_grid_frame() * p).distance,
                  straight.sample(straight.T_grid_frame() * p).distance, 0.03)
          << "yaw " << yaw << " at " << p.transpose();
    }
  }
}

}  // namespace
}  // namespace cornerfix

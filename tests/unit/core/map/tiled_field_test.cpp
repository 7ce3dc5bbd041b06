#include "core/src/map/tiled_field.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace cornerfix {
namespace {

constexpr Pose2 kT_frame_grid{-10.0, 4.0, 0.0};
constexpr double kResolution = 0.1;
constexpr int kCells = 300;  // 30 m, not a whole number of tiles

/// Along a few walls, some of them outside.
std::vector<Point2> wall_points(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-2.0, 32.0);
  std::vector<Point2> points;
  for (int wall = 0; wall < 6; ++wall) {
    const Point2 begin(place(random), place(random));
    const Point2 end(place(random), place(random));
    for (int i = 0; i < 40; ++i) points.push_back(begin + (end - begin) * (i / 200.0));
  }
  return points;
}

struct BothFields {
  DistanceField dense{kT_frame_grid, kResolution, kCells, kCells};
  TiledField tiled{kT_frame_grid, kResolution, kCells, kCells};

  void stamp(const std::vector<Point2>& points, double radius_m) {
    dense.stamp(points, radius_m);
    tiled.stamp(points, radius_m);
  }

  void expect_same_cells() const {
    for (int row = 0; row + 1 < kCells; ++row) {
      for (int column = 0; column + 1 < kCells; ++column) {
        const FieldSquare expected = dense.square(column, row);
        const FieldSquare square = tiled.square(column, row);
        for (int i = 0; i < 2; ++i) {
          ASSERT_EQ(square.lower[i], expected.lower[i]) << column + i << ", " << row;
          ASSERT_EQ(square.upper[i], expected.upper[i]) << column + i << ", " << row + 1;
        }
      }
    }
  }
};

TEST(TiledField, HasTheCellsOfADenseField) {
  for (const double radius_m : {0.05, 0.5, 1.3, 2.4}) {
    BothFields fields;
    fields.stamp(wall_points(7), radius_m);
    fields.expect_same_cells();
  }
}

TEST(TiledField, HasTheDistancesOfADenseField) {
  BothFields fields;
  fields.stamp(wall_points(3), 0.5);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> place(-1.0, 31.0);
  for (int i = 0; i < 20'000; ++i) {
    const Point2 point(place(random), place(random));
    ASSERT_EQ(fields.tiled.distance(point), fields.dense.distance(point)) << point.transpose();
    ASSERT_EQ(fields.tiled.nearest(point), fields.dense.nearest(point)) << point.transpose();
  }
}

TEST(TiledField, IsFarHoweverFarOutside) {
  TiledField field(kT_frame_grid, kResolution, kCells, kCells);
  for (const double far : {-1e-9, -3e9, 3e9, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(field.nearest({far, 0.5}), DistanceField::kMaxDistance) << far;
    EXPECT_EQ(field.distance({0.5, far}), DistanceField::kMaxDistance) << far;
  }
}

TEST(TiledField, HasMemoryForWhatWasStampedOnly) {
  TiledField field(kT_frame_grid, kResolution, kCells, kCells);
  const std::size_t empty = field.bytes();
  EXPECT_LT(empty, 2'000U);
  field.stamp(std::vector{Point2(15.0, 15.0)}, 0.5);
  EXPECT_LT(field.bytes(), empty + 10'000U);
  field.stamp(wall_points(7), 0.5);
  EXPECT_LT(field.bytes(), static_cast<std::size_t>(kCells) * kCells / 2);
}

TEST(TiledField, IsFarEverywhereOnceCleared) {
  BothFields fields;
  fields.stamp(wall_points(7), 0.5);
  const Pose2 T_frame_elsewhere{3.0, -8.0, 0.0};
  fields.tiled.clear(T_frame_elsewhere);
  EXPECT_EQ(fields.tiled.T_grid_frame(), inverse(T_frame_elsewhere));
  fields.dense = DistanceField(T_frame_elsewhere, kResolution, kCells, kCells);
  fields.expect_same_cells();
  fields.stamp(wall_points(9), 0.5);
  fields.expect_same_cells();
}

}  // namespace
}  // namespace cornerfix

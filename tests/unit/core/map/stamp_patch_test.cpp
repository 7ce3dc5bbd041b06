#include "core/src/map/stamp_patch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace cornerfix {
namespace {

constexpr int kWidth = 50;
constexpr int kHeight = 40;

/// Cells of 0.1 m: 10 steps per cell.
const DistanceField kField({}, 0.1, kWidth, kHeight);

/// The cells that the patches of stamps lower, row by row.
std::vector<std::uint8_t> lowered(const std::vector<Point2>& points_grid, double radius_m) {
  std::vector<std::uint8_t> field(kWidth * kHeight, 255);
  for_each_patch(kField, points_grid, radius_m, [&](const StampPatch& patch) {
    for (int row = patch.first_row(); row <= patch.last_row(); ++row) {
      const std::uint8_t* cells = patch.cells(patch.first_column(), row);
      for (int column = patch.first_column(); column <= patch.last_column(); ++column) {
        std::uint8_t& cell = field[static_cast<std::size_t>(row * kWidth + column)];
        cell = std::min(cell, cells[column - patch.first_column()]);
      }
    }
  });
  return field;
}

TEST(StampPatch, HoldsTheDistancesOfAllCellsOfTheSquare) {
  const Point2 point(2.03, 1.79);  // A square of 41 x 41 cells, which is more than one part.
  const std::vector<std::uint8_t> field = lowered({point}, 2.0);
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const double dx = column + 0.5 - 10.0 * point.x();
      const double dy = row + 0.5 - 10.0 * point.y();
      const bool is_in_square = std::abs(dx) <= 20.0 && std::abs(dy) <= 20.0;
      const double steps = std::min(255.0, 10.0 * std::hypot(dx, dy));
      EXPECT_NEAR(field[static_cast<std::size_t>(row * kWidth + column)],
                  is_in_square ? std::floor(steps) : 255.0, 1.0)
          << column << ", " << row;
    }
  }
}

TEST(StampPatch, LowersTogetherWhatStampsLowerOneByOne) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> step(-0.4, 0.4);
  for (const double radius_m : {0.05, 0.5, 0.75, 1.3}) {
    std::vector<Point2> points;  // A way that turns, with some jumps, and leaves the field.
    for (int i = 0; i < 60; ++i) {
      const Point2 before = i % 20 == 0 ? Point2(0.08 * i, 2.0) : points.back();
      points.emplace_back(before + Point2(step(random), step(random)));
    }
    std::vector<std::uint8_t> one_by_one(kWidth * kHeight, 255);
    for (const Point2& point : points) {
      std::ranges::transform(one_by_one, lowered({point}, radius_m), one_by_one.begin(),
                             [](std::uint8_t a, std::uint8_t b) { return std::min(a, b); });
    }
    EXPECT_EQ(lowered(points, radius_m), one_by_one) << radius_m;
  }
}

TEST(StampPatch, IsPaddedSoThatWholeRowsCanBeLowered) {
  StampSquares squares;
  squares.add(stamp_place({10.5, 10.5}, 2.0, kWidth, kHeight));
  const StampPatch patch(squares, 10.0F);
  const std::uint8_t* before = patch.cells(patch.first_column() - StampPatch::kPadding, 10);
  EXPECT_EQ(before[StampPatch::kPadding - 1], 255);
  EXPECT_LT(before[StampPatch::kPadding], 255);
  const std::uint8_t* last = patch.cells(patch.last_column(), 10);
  EXPECT_LT(last[0], 255);
  for (int i = 1; i <= StampPatch::kPadding; ++i) EXPECT_EQ(last[i], 255) << i;
}

TEST(StampSquares, HaveRoomForTheStampsOfABlock) {
  StampSquares squares;
  EXPECT_TRUE(squares.is_empty());
  squares.restart(stamp_place({20.5, 20.5}, 5.0, kWidth, kHeight));
  for (const double x : {16.0, 24.0, 31.9}) {
    for (const double y : {16.0, 24.0, 31.9}) {
      const StampPlace stamp = stamp_place({x, y}, 5.0, kWidth, kHeight);
      ASSERT_TRUE(squares.has_room_for(stamp)) << x << ", " << y;
      squares.add(stamp);
    }
  }
  EXPECT_FALSE(squares.is_empty());
  EXPECT_FALSE(squares.has_room_for(stamp_place({40.5, 20.5}, 5.0, kWidth, kHeight)));
  squares.restart(stamp_place({40.5, 20.5}, 5.0, kWidth, kHeight));
  EXPECT_TRUE(squares.is_empty());
}

TEST(StampPlace, ComesBesideItsNeighbours) {
  const StampPlace here = stamp_place({3.5, 4.5}, 2.0, kWidth, kHeight);
  const StampPlace there = stamp_place({40.5, 4.5}, 2.0, kWidth, kHeight);
  const StampPlace beside = stamp_place({8.5, 9.5}, 2.0, kWidth, kHeight);
  const std::vector<StampPlace> sorted =
      by_block(std::vector{here, there, beside}, kWidth, kHeight);
  ASSERT_EQ(sorted.size(), 3U);
  EXPECT_EQ(sorted[0].column, here.column);
  EXPECT_EQ(sorted[1].column, beside.column);
  EXPECT_EQ(sorted[2].column, there.column);
}

TEST(StampPlace, IsClippedToTheField) {
  const StampPlace corner = stamp_place({0.5, 39.5}, 3.0, kWidth, kHeight);
  EXPECT_EQ(corner.first_column, 0);
  EXPECT_EQ(corner.last_column, 3);
  EXPECT_EQ(corner.first_row, 36);
  EXPECT_EQ(corner.last_row, 39);
}

TEST(StampPlace, IsEmptyOutsideTheField) {
  const StampPlace place = stamp_place({-10.0, 5.0}, 3.0, kWidth, kHeight);
  EXPECT_LT(place.last_column, place.first_column);
}

}  // namespace
}  // namespace cornerfix

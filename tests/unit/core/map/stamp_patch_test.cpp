#include "core/src/map/stamp_patch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace cornerfix {
namespace {

constexpr int kWidth = 50;
constexpr int kHeight = 40;
constexpr float kStepsPerCell = 10.0F;

/// The field that the patches of a stamp lower, row by row.
std::vector<std::uint8_t> lowered(const StampPlace& place) {
  std::vector<std::uint8_t> field(kWidth * kHeight, 255);
  for_each_patch(place, kStepsPerCell, [&](const StampPatch& patch) {
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
  const Point2 point(20.3, 17.9);  // A square of 41 x 41 cells, which is more than one patch.
  const std::vector<std::uint8_t> field = lowered(stamp_place(point, 20.0, kWidth, kHeight));
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const double dx = column + 0.5 - point.x();
      const double dy = row + 0.5 - point.y();
      const bool is_in_square = std::abs(dx) <= 20.0 && std::abs(dy) <= 20.0;
      const double steps = std::min(255.0, kStepsPerCell * std::hypot(dx, dy));
      EXPECT_NEAR(field[static_cast<std::size_t>(row * kWidth + column)],
                  is_in_square ? std::floor(steps) : 255.0, 1.0)
          << column << ", " << row;
    }
  }
}

TEST(StampPatch, IsPaddedSoThatWholeRowsCanBeLowered) {
  const StampPlace place = stamp_place({10.5, 10.5}, 2.0, kWidth, kHeight);
  const StampPatch patch(place, place.first_column, place.first_row, kStepsPerCell);
  const std::uint8_t* before = patch.cells(patch.first_column() - StampPatch::kSide, 10);
  EXPECT_EQ(before[StampPatch::kSide - 1], 255);
  EXPECT_LT(before[StampPatch::kSide], 255);
  const std::uint8_t* last = patch.cells(patch.last_column(), 10);
  EXPECT_LT(last[0], 255);
  for (int i = 1; i <= StampPatch::kSide; ++i) EXPECT_EQ(last[i], 255) << i;
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

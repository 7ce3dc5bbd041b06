#include "core/src/search/place_fields.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "support/drawn_grid.hpp"

namespace cornerfix {
namespace {

constexpr int kBlockColumns = 12;
constexpr int kBlockRows = 8;
constexpr std::uint8_t kBeyond = 7;

std::vector<std::uint8_t> random_cells() {
  std::mt19937_64 random(2);
  std::vector<std::uint8_t> cells(kBlockColumns * kBlockRows);
  for (std::uint8_t& cell : cells) cell = static_cast<std::uint8_t>(random() % 32);
  return cells;
}

TEST(BlockField, HoldsTheMaximumOfEachBlockOfCells) {
  const std::vector<std::uint8_t> cells = random_cells();
  const BlockField field(cells, kBlockColumns, kBlockRows, kBeyond);
  const auto at = [&](int x, int y) {
    return x < kBlockColumns && y < kBlockRows
               ? cells[static_cast<std::size_t>(y * kBlockColumns + x)]
               : kBeyond;
  };
  for (int y = 0; y < kBlockRows; ++y) {
    for (int x = 0; x < kBlockColumns; ++x) {
      const auto block = {at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)};
      EXPECT_EQ(field.cell(x, y), at(x, y));
      EXPECT_EQ(*field.maxima_from(x, y), std::max(block)) << x << ", " << y;
    }
  }
}

TEST(BlockField, BlocksOfARowFollowEachOther) {
  const BlockField field(random_cells(), kBlockColumns, kBlockRows, kBeyond);
  const std::uint8_t* row = field.maxima_from(1, 3);
  EXPECT_EQ(row + 1, field.maxima_from(1 + kBlock, 3));
  EXPECT_EQ(row + field.blocks_a_row(), field.maxima_from(1, 3 + kBlock));
}

class PlaceFieldsOfARoom : public ::testing::Test {
 protected:
  PlaceFieldsOfARoom()
      : grid_(testing::drawn_grid(testing::SceneBuilder().room({0, 0}, {6, 4}), {3.0, 2.0},
                                  {-1.0, -1.0, 0.0}, {8.0, 6.0}, 0.05)),
        fields_(ClassField(grid_, DistanceField(grid_))) {}

  /// Column or row of a coordinate of `map`, border included.
  [[nodiscard]] std::ptrdiff_t cell(double coordinate) const {
    return kBorder + static_cast<std::ptrdiff_t>(std::floor((coordinate + 1.0) / fields_.cell_m));
  }

  OccupancyGrid grid_;
  PlaceFields fields_;
};

TEST_F(PlaceFieldsOfARoom, HaveCellsOfAboutTwentyCentimetresAndWholeBlocks) {
  EXPECT_NEAR(fields_.cell_m, 0.2, 1e-9);
  EXPECT_EQ(fields_.inner_width, 40);
  EXPECT_EQ(fields_.inner_height, 30);
  EXPECT_EQ(fields_.width % kBlock, 0);
  EXPECT_EQ(fields_.height % kBlock, 0);
}

TEST_F(PlaceFieldsOfARoom, GiveTheHighestValueToHitsOnAWall) {
  EXPECT_EQ(fields_.ends.cell(cell(6.0), cell(2.0)), kHighestValue);
  EXPECT_LT(fields_.ends.cell(cell(3.0), cell(2.0)), kHighestValue / 2);
}

TEST_F(PlaceFieldsOfARoom, AllowThePathInFreeSpaceOnly) {
  EXPECT_EQ(fields_.way.cell(cell(3.0), cell(2.0)), kWayFree);
  EXPECT_EQ(fields_.way.cell(cell(6.9), cell(2.0)), kWayUnknown);
}

TEST_F(PlaceFieldsOfARoom, AreUnknownInTheBorder) {
  EXPECT_EQ(fields_.way.cell(3, 3), kWayUnknown);
  EXPECT_EQ(fields_.ends.cell(3, 3), fields_.ends.cell(fields_.width - 3, fields_.height - 3));
}

}  // namespace
}  // namespace cornerfix

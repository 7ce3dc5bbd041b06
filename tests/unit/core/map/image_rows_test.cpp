#include "core/src/map/image_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace cornerfix {
namespace {

TEST(ImageRows, PutsTheUppermostRowAtTheHighestY) {
  Result<ImageRows> rows = ImageRows::create(2, 2, 0.1, {1.0, 2.0, 0.0}, {});
  ASSERT_TRUE(rows);
  rows->allocate();
  for (int row = 0; row < 2; ++row) {
    std::ranges::fill(rows->row(row), row == 0 ? Cell::kOccupied : Cell::kFree);
    rows->finish_row(row);
  }
  const OccupancyGrid grid = std::move(*rows).take();
  EXPECT_EQ(grid.at({0, 1}), Cell::kOccupied);
  EXPECT_EQ(grid.at({0, 0}), Cell::kFree);
  EXPECT_EQ(grid.T_map_grid, (Pose2{1.0, 2.0, 0.0}));
}

TEST(ImageRows, ThinAnImageThatIsTooFine) {
  // Two pixels of 2.5 cm a cell of 5 cm, both ways.
  Result<ImageRows> rows = ImageRows::create(8, 8, 0.025, {}, {.max_cells = 16});
  ASSERT_TRUE(rows);
  ASSERT_TRUE(rows->is_thinned());
  rows->allocate();
  for (int row = 0; row < 8; ++row) {
    std::ranges::fill(rows->row(row), Cell::kUnknown);
    if (row == 7) rows->row(row)[0] = Cell::kFree;  // lowest left cell: free, occupied
    if (row == 6) rows->row(row)[1] = Cell::kOccupied;
    if (row == 7) rows->row(row)[7] = Cell::kFree;  // lowest right cell: free, unknown
    rows->finish_row(row);
  }
  const OccupancyGrid grid = std::move(*rows).take();
  ASSERT_EQ(grid.width, 4);
  ASSERT_EQ(grid.height, 4);
  EXPECT_EQ(grid.resolution, kThinnedResolution);
  EXPECT_EQ(grid.at({0, 0}), Cell::kOccupied);
  EXPECT_EQ(grid.at({3, 0}), Cell::kFree);
  EXPECT_EQ(grid.at({1, 1}), Cell::kUnknown);
}

TEST(ImageRows, RefuseAnImageThatIsTooLargeAndCoarse) {
  const Result<ImageRows> rows = ImageRows::create(8, 8, 0.1, {}, {.max_cells = 16});
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().code, ErrorCode::kTooLarge);
  EXPECT_NE(rows.error().message.find("0.2 m or coarser"), std::string::npos);
}

TEST(ImageRows, RefuseAnImageWithoutPixels) { EXPECT_FALSE(ImageRows::create(0, 8, 0.1, {}, {})); }

}  // namespace
}  // namespace cornerfix

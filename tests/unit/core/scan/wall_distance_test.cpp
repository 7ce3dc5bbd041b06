#include "core/src/scan/wall_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cornerfix {
namespace {

OccupancyGrid grid_with_walls(int width, int height, const std::vector<CellIndex>& walls) {
  OccupancyGrid grid;
  grid.width = width;
  grid.height = height;
  grid.cells.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                    Cell::kFree);
  for (const CellIndex& wall : walls) grid.cells[grid.offset(wall)] = Cell::kOccupied;
  return grid;
}

TEST(WallDistance, IsTheDistanceBetweenCellCentres) {
  const OccupancyGrid grid = grid_with_walls(20, 10, {{2, 3}, {15, 9}});
  const std::vector<float> distances = distances_to_walls(grid);
  ASSERT_EQ(distances.size(), grid.cells.size());
  EXPECT_EQ(distances[grid.offset({2, 3})], 0.0F);
  EXPECT_NEAR(distances[grid.offset({5, 7})], 5.0F, 1e-4F);
  EXPECT_NEAR(distances[grid.offset({16, 8})], std::sqrt(2.0F), 1e-4F);
}

TEST(WallDistance, IsInfiniteWithoutAWall) {
  for (const float distance : distances_to_walls(grid_with_walls(4, 3, {})))
    EXPECT_TRUE(std::isinf(distance));
  EXPECT_TRUE(distances_to_walls({}).empty());
}

TEST(WallDistance, IsRightAcrossThePartsOfAWideGrid) {
  const OccupancyGrid grid = grid_with_walls(6'000, 2, {{2'100, 0}, {5'990, 1}});
  const std::vector<float> distances = distances_to_walls(grid);
  EXPECT_NEAR(distances[grid.offset({2'000, 0})], 100.0F, 1e-3F);
  EXPECT_NEAR(distances[grid.offset({2'300, 0})], 200.0F, 1e-3F);
  EXPECT_NEAR(distances[grid.offset({5'999, 1})], 9.0F, 1e-3F);
  EXPECT_GE(distances[grid.offset({4'000, 0})], 256.0F);
}

}  // namespace
}  // namespace cornerfix

#include "core/src/map/wall_surfaces.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace cornerfix {
namespace {

/// Rows from the highest y down: '#' occupied, '.' free, anything else unknown.
OccupancyGrid grid_of(const std::vector<std::string>& rows, double resolution = 0.05) {
  OccupancyGrid grid;
  grid.resolution = resolution;
  grid.width = static_cast<int>(rows.front().size());
  grid.height = static_cast<int>(rows.size());
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
    for (const char c : *row) {
      grid.cells.push_back(c == '#' ? Cell::kOccupied : c == '.' ? Cell::kFree : Cell::kUnknown);
    }
  }
  return grid;
}

WallSurfaces surfaces_of(const OccupancyGrid& grid) {
  const Result<WallSurfaces> surfaces = find_wall_surfaces(grid, 0.05, 1e6);
  EXPECT_TRUE(surfaces) << surfaces.error().message;
  return surfaces ? *surfaces : WallSurfaces{};
}

Cell cell_at(const OccupancyGrid& grid, const Point2& point_map) {
  return grid.at(grid.cell_of(inverse(grid.T_map_grid) * point_map));
}

TEST(WallSurfaces, AThinWallStaysWhereItIs) {
  const OccupancyGrid map = grid_of({"....", "####", "....", "...."});
  const WallSurfaces surfaces = surfaces_of(map);
  EXPECT_DOUBLE_EQ(surfaces.median_thickness_m, 0.05);
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      EXPECT_EQ(cell_at(surfaces.grid, map.center({column, row})), map.at({column, row}));
    }
  }
}

TEST(WallSurfaces, AThickWallIsItsBorderToFreeSpace) {
  // Free for x < 0.15 m, wall up to 0.40 m.
  const WallSurfaces surfaces =
      surfaces_of(grid_of({"...#####", "...#####", "...#####", "...#####"}));
  EXPECT_DOUBLE_EQ(surfaces.median_thickness_m, 0.25);
  EXPECT_EQ(cell_at(surfaces.grid, {0.15, 0.10}), Cell::kOccupied);
  EXPECT_EQ(cell_at(surfaces.grid, {0.10, 0.10}), Cell::kFree);
  EXPECT_EQ(cell_at(surfaces.grid, {0.20, 0.10}), Cell::kUnknown);
}

TEST(WallSurfaces, CellsAreCentredOnTheBordersOfThickWalls) {
  const OccupancyGrid grid = surfaces_of(grid_of({"..####", "..####"})).grid;
  const Point2 in_cells = inverse(grid.T_map_grid) * Point2(0.10, 0.05) / grid.resolution;
  EXPECT_NEAR(in_cells.x() - std::floor(in_cells.x()), 0.5, 1e-6);
}

TEST(WallSurfaces, CoarseCellsAreCutAndFineOnesMerged) {
  EXPECT_DOUBLE_EQ(surfaces_of(grid_of({"..#"}, 0.11)).grid.resolution, 0.055);
  EXPECT_DOUBLE_EQ(surfaces_of(grid_of({"..#"}, 0.01)).grid.resolution, 0.05);
  EXPECT_DOUBLE_EQ(surfaces_of(grid_of({"..#"}, 0.06)).grid.resolution, 0.06);
}

TEST(WallSurfaces, AWallOfFineCellsIsNotLostWhenTheyAreMerged) {
  std::vector<std::string> rows(20, "..........#.........");
  const OccupancyGrid grid = surfaces_of(grid_of(rows, 0.01)).grid;
  for (double y = 0.005; y < 0.2; y += 0.01) {
    EXPECT_EQ(cell_at(grid, {0.105, y}), Cell::kOccupied) << y;
  }
}

TEST(WallSurfaces, ATurnedMapStaysTurned) {
  OccupancyGrid map = grid_of({"....", "####", "...."});
  map.T_map_grid = {3.0, -2.0, 0.7};
  const OccupancyGrid grid = surfaces_of(map).grid;
  EXPECT_DOUBLE_EQ(grid.T_map_grid.yaw, 0.7);
  EXPECT_EQ(cell_at(grid, map.T_map_grid * map.center({2, 1})), Cell::kOccupied);
}

TEST(WallSurfaces, OnlyWhatIsKnownIsKept) {
  std::vector<std::string> rows(400, std::string(400, '?'));
  rows[200] = std::string(200, '?') + ".#" + std::string(198, '?');
  const OccupancyGrid grid = surfaces_of(grid_of(rows)).grid;
  EXPECT_LT(grid.width, 40);
  EXPECT_LT(grid.height, 40);
}

TEST(WallSurfaces, AMapTooLargeAtTheWantedResolutionIsRefused) {
  const OccupancyGrid map = grid_of(std::vector<std::string>(100, std::string(100, '.')), 5.0);
  const Result<WallSurfaces> surfaces = find_wall_surfaces(map, 0.05, 1e6);
  ASSERT_FALSE(surfaces);
  EXPECT_EQ(surfaces.error().code, ErrorCode::kTooLarge);
}

TEST(GreyRims, BetweenFreeSpaceAndAWallAreFree) {
  EXPECT_EQ(without_grey_rims(grid_of({"...??#??????"})), grid_of({".....#??????"}));
}

TEST(GreyRims, WiderOnesAndTheUnknownBehindWallsStay) {
  const OccupancyGrid wide = grid_of({"..??????#?.."});
  EXPECT_EQ(without_grey_rims(wide), grid_of({"..??????#..."}));
  const OccupancyGrid behind = grid_of({"..#??", "..#??", "..#??"});
  EXPECT_EQ(without_grey_rims(behind), behind);
}

}  // namespace
}  // namespace cornerfix

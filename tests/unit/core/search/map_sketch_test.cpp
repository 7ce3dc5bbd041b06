#include <cornerfix/map_sketch.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include <cornerfix/mapper.hpp>

#include "support/storeys.hpp"

namespace cornerfix {
namespace {

/// A free room of 2 m x 2 m with a wall around it, in cells of 0.1 m; unknown beyond.
OccupancyGrid square_room() {
  OccupancyGrid grid;
  grid.resolution = 0.1;
  grid.T_map_grid = {5.0, -3.0, 0.0};
  grid.width = grid.height = 40;
  grid.cells.assign(40 * 40, Cell::kUnknown);
  for (int row = 9; row <= 30; ++row) {
    for (int column = 9; column <= 30; ++column) {
      const bool is_wall = row == 9 || row == 30 || column == 9 || column == 30;
      grid.cells[grid.offset({column, row})] = is_wall ? Cell::kOccupied : Cell::kFree;
    }
  }
  return grid;
}

HitLevel level_at(const MapSketch& sketch, const Point2& point_map) {
  const Point2 p = inverse(sketch.T_map_grid) * point_map / sketch.cell_m;
  return sketch.level(static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())));
}

TEST(MapSketch, KnowsWallsFreeSpaceAndWhatIsUnknown) {
  const testing::Storey storey = testing::random_storey(500);
  const Result<GridMap> made = map_from_grid(storey.grid(), {});
  const MapSketch sketch = sketch_of(made.value().content.features, made.value().content.grid);
  EXPECT_EQ(level_at(sketch, {0.0, storey.inside.y()}), HitLevel::kWall);
  EXPECT_EQ(level_at(sketch, {0.5, storey.inside.y()}), HitLevel::kFree);
  EXPECT_EQ(level_at(sketch, {-20.0, 0.0}), HitLevel::kUnknown);
  EXPECT_GT(sketch.corners.size(), 20U);
  EXPECT_NEAR(sketch.cell_m, 0.2, 1e-9);
}

TEST(MapSketch, TakesTheMostLikelyLevelOfTheCellsThatItJoins) {
  const MapSketch sketch = sketch_of({}, square_room());
  EXPECT_EQ(sketch.width, 20);
  EXPECT_EQ(sketch.height, 20);
  EXPECT_NEAR(sketch.free_area_m2, 4.0, 1e-9);
  EXPECT_EQ(level_at(sketch, {5.95, -1.0}), HitLevel::kWall);
  EXPECT_EQ(level_at(sketch, {6.5, -1.0}), HitLevel::kFree);
  EXPECT_EQ(level_at(sketch, {7.0, -1.0}), HitLevel::kFarFree) << "1 m from the walls";
}

TEST(MapSketch, HoldsCornersInItsOwnFrame) {
  Feature corner;
  corner.position = {6.0, -2.0};
  corner.bisector = 0.5;
  corner.convex = true;
  const MapSketch sketch = sketch_of(std::vector{corner}, square_room());
  ASSERT_EQ(sketch.corners.size(), 1U);
  EXPECT_NEAR(sketch.corners[0].x, 1.0, 1e-6);
  EXPECT_NEAR(sketch.corners[0].y, 1.0, 1e-6);
  EXPECT_NEAR(sketch.corners[0].bisector, 0.5, 1e-6);
  EXPECT_TRUE(sketch.corners[0].convex);
}

TEST(MapSketch, KeepsTheCornersThatWereSeenMostOften) {
  std::vector<Feature> corners(MapSketch::kMaxCorners + 1);
  for (Feature& corner : corners) corner.count = 2;
  corners.front().count = 1;
  corners.front().convex = true;
  const MapSketch sketch = sketch_of(corners, square_room());
  ASSERT_EQ(sketch.corners.size(), MapSketch::kMaxCorners);
  for (const SketchCorner& corner : sketch.corners) ASSERT_FALSE(corner.convex);
}

}  // namespace
}  // namespace cornerfix

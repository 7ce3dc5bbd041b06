#include "core/src/scan/simulated_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/drawn_grid.hpp"

namespace cornerfix {
namespace {

OccupancyGrid mapped_room(const Point2& size_m) {
  const testing::SceneBuilder scene = testing::SceneBuilder().room({0, 0}, size_m);
  return testing::drawn_grid(scene, {1.0, 1.0}, {-1.0, -1.0, 0.0}, size_m + Point2::Constant(2.0),
                             0.05);
}

void occupy(OccupancyGrid& grid, const Point2& low, const Point2& high, Cell cell) {
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      const Point2 p = grid.T_map_grid * grid.center({column, row});
      if ((p.array() > low.array()).all() && (p.array() < high.array()).all())
        grid.cells[grid.offset({column, row})] = cell;
    }
  }
}

std::size_t beam_towards(const LaserScan& scan, double heading) {
  return static_cast<std::size_t>(std::lround((heading - scan.angle_min) / scan.angle_increment));
}

TEST(SimulatedLidar, SeesWallsToWithinACell) {
  const OccupancyGrid map = mapped_room({8.0, 6.0});
  const LaserScan scan = SimulatedLidar(map).scan({3.0, 2.0});
  EXPECT_NEAR(scan.ranges[beam_towards(scan, 0.0)], 5.0, 0.051);
  EXPECT_NEAR(scan.ranges[beam_towards(scan, std::numbers::pi / 2)], 4.0, 0.051);
}

TEST(SimulatedLidar, HasNoReturnFromBeyondTheUnknown) {
  OccupancyGrid map = mapped_room({8.0, 6.0});
  occupy(map, {5.0, 0.1}, {6.0, 5.9}, Cell::kUnknown);
  const LaserScan scan = SimulatedLidar(map).scan({3.0, 3.0});
  EXPECT_FALSE(scan.has_return(beam_towards(scan, 0.0)));
}

TEST(SimulatedLidar, SeesThroughANarrowUnknownGap) {
  OccupancyGrid map = mapped_room({8.0, 6.0});
  occupy(map, {5.0, 0.1}, {5.15, 5.9}, Cell::kUnknown);
  const LaserScan scan = SimulatedLidar(map).scan({3.0, 3.0});
  EXPECT_NEAR(scan.ranges[beam_towards(scan, 0.0)], 5.0, 0.051);
}

TEST(SimulatedLidar, LooksFromEverySquareMetreOfFreeSpaceAndFromNoWall) {
  const OccupancyGrid map = mapped_room({8.0, 6.0});
  const SimulatedLidar lidar(map);
  const auto viewpoints = lidar.viewpoints(1.0, 0.25);
  EXPECT_GE(viewpoints.size(), 48U);
  EXPECT_LE(viewpoints.size(), 63U);
  for (const Point2& p : viewpoints) {
    EXPECT_GE(std::min({p.x(), p.y(), 8.0 - p.x(), 6.0 - p.y()}), 0.2) << p.transpose();
  }
}

TEST(SimulatedLidar, LooksIntoACorridorThatTheLatticeMisses) {
  const OccupancyGrid map = mapped_room({20.0, 0.8});
  OccupancyGrid corridor = map;
  occupy(corridor, {0.05, 0.05}, {19.95, 0.75}, Cell::kFree);
  EXPECT_GE(SimulatedLidar(corridor).viewpoints(1.0, 0.25).size(), 19U);
}

TEST(SimulatedLidar, LooksFromNoSliverThatWasSeenThroughAWindow) {
  OccupancyGrid map = mapped_room({12.0, 6.0});
  occupy(map, {8.0, 0.1}, {11.9, 5.9}, Cell::kUnknown);
  occupy(map, {7.9, 0.1}, {8.0, 5.9}, Cell::kOccupied);
  occupy(map, {8.0, 2.0}, {9.5, 2.8}, Cell::kFree);
  for (const Point2& p : SimulatedLidar(map).viewpoints(1.0, 0.25)) EXPECT_LT(p.x(), 8.0);
  occupy(map, {8.0, 2.0}, {11.0, 4.0}, Cell::kFree);  // a room of its own
  const auto viewpoints = SimulatedLidar(map).viewpoints(1.0, 0.25);
  EXPECT_TRUE(std::ranges::any_of(viewpoints, [](const Point2& p) { return p.x() > 8.0; }));
}

}  // namespace
}  // namespace cornerfix

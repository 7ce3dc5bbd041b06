#include <cornerfix/occupancy_grid.hpp>

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

namespace cornerfix {
namespace {

using std::numbers::pi;

/// A free room of 10 x 8 m with walls one cell thick, its lower left inner corner at (0, 0).
OccupancyGrid box_room(double resolution) {
  OccupancyGrid grid;
  grid.resolution = resolution;
  grid.width = static_cast<int>(std::lround(10.0 / resolution)) + 2;
  grid.height = static_cast<int>(std::lround(8.0 / resolution)) + 2;
  grid.T_map_grid = {-resolution, -resolution, 0.0};
  grid.cells.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                    Cell::kFree);
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      if (row == 0 || column == 0 || row == grid.height - 1 || column == grid.width - 1) {
        grid.cells[grid.offset({column, row})] = Cell::kOccupied;
      }
    }
  }
  return grid;
}

double distance_to_wall_of_box_room(const Point2& p, double heading) {
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  const double x = c > 0 ? (10.0 - p.x()) / c : -p.x() / c;
  const double y = s > 0 ? (8.0 - p.y()) / s : -p.y() / s;
  return std::min(x, y);
}

TEST(RayCaster, MeasuresABoxRoomAsGeometryDoes) {
  const RayCaster caster(box_room(0.05));
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> x(0.1, 9.9), y(0.1, 7.9), heading(-pi, pi);
  for (int i = 0; i < 2000; ++i) {
    const Point2 p{x(random), y(random)};
    const double a = heading(random);
    EXPECT_NEAR(caster.cast(p, a, 30.0), distance_to_wall_of_box_room(p, a), 1e-3)
        << p.transpose() << " heading " << a;
  }
}

TEST(RayCaster, LooksAlongAxesExactly) {
  const RayCaster caster(box_room(0.05));
  EXPECT_NEAR(caster.cast({4.0, 3.0}, 0.0, 30.0), 6.0, 1e-6);
  EXPECT_NEAR(caster.cast({4.0, 3.0}, pi / 2.0, 30.0), 5.0, 1e-6);
  EXPECT_NEAR(caster.cast({4.0, 3.0}, pi, 30.0), 4.0, 1e-6);
}

TEST(RayCaster, DoesNotCreepAlongAGridLine) {
  OccupancyGrid corridor;
  corridor.resolution = 0.125;
  corridor.width = 20'000;
  corridor.height = 4;
  corridor.cells.assign(80'000, Cell::kFree);
  corridor.cells[corridor.offset({0, 2})] = Cell::kOccupied;
  corridor.cells[corridor.offset({0, 1})] = Cell::kOccupied;
  // sin(-pi) is just below zero: the ray never leaves the grid line that it begins on.
  EXPECT_NEAR(RayCaster(corridor).cast({2'400.0, 0.25}, -pi, 3'000.0), 2'399.875, 1e-3);
}

TEST(RayCaster, TakesMinusZeroForADirectionAsItTakesZero) {
  OccupancyGrid corridor;  // So narrow that a ray goes from grid line to grid line.
  corridor.resolution = 0.125;
  corridor.width = 20'000;
  corridor.height = 4;
  corridor.cells.assign(80'000, Cell::kFree);
  for (int column = 0; column < corridor.width; ++column) {
    corridor.cells[corridor.offset({column, 0})] = Cell::kOccupied;
    corridor.cells[corridor.offset({column, 3})] = Cell::kOccupied;
  }
  corridor.cells[corridor.offset({19'999, 2})] = Cell::kOccupied;
  corridor.cells[corridor.offset({19'999, 1})] = Cell::kOccupied;
  const RayCaster caster(corridor);
  for (const double beside : {0.0, 1e-16, -1e-16}) {  // Of a grid line.
    const Point2 origin{2.0, 0.25 + beside};
    EXPECT_NEAR(caster.cast(origin, -0.0, 3'000.0), 2'497.875, 1e-2) << beside;
    EXPECT_EQ(caster.cast(origin, -0.0, 3'000.0), caster.cast(origin, 0.0, 3'000.0)) << beside;
  }
}

TEST(RayCaster, AScanIsItsBeamsCastOneByOne) {
  OccupancyGrid turned = box_room(0.05);
  turned.T_map_grid = Pose2{3.0, -2.0, 0.7} * turned.T_map_grid;
  const RayCaster caster(turned);
  const Pose2 T_map_laser = Pose2{3.0, -2.0, 0.7} * Pose2{4.0, 3.0, -1.1};
  const LaserScan lidar{.stamp = 0.0,
                        .angle_min = -2.0,
                        .angle_increment = 0.02,
                        .range_min = 0.0,
                        .range_max = 30.0,
                        .ranges = {}};
  const LaserScan scan = caster.scan(lidar, 200, T_map_laser);
  ASSERT_EQ(scan.ranges.size(), 200U);
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const double heading = T_map_laser.yaw + scan.bearing(beam);
    EXPECT_NEAR(scan.ranges[beam], caster.cast(T_map_laser.translation(), heading, 30.0), 1e-4)
        << beam;
  }
}

TEST(RayCaster, SeesASingleOccupiedCellFromAfar) {
  OccupancyGrid grid = box_room(0.05);
  grid.cells[grid.offset(grid.cell_of({9.025 + 0.05, 4.025 + 0.05}))] = Cell::kOccupied;
  EXPECT_NEAR(RayCaster(grid).cast({1.0, 4.02}, 0.0, 30.0), 8.0, 1e-6);
}

TEST(RayCaster, SeesTheWallsOfAVeryWideGrid) {
  OccupancyGrid grid;
  grid.resolution = 0.05;
  grid.width = 12'000;
  grid.height = 40;
  grid.cells.assign(480'000, Cell::kFree);
  for (int column = 300; column < grid.width; column += 300) {
    for (int row = 0; row < grid.height; ++row)
      grid.cells[grid.offset({column, row})] = Cell::kOccupied;
  }
  const RayCaster caster(grid);
  for (int column = 301; column < grid.width - 300; column += 300) {
    const Point2 p{(column + 50) * grid.resolution, 1.0};
    EXPECT_NEAR(caster.cast(p, 0.0, 30.0), 249 * grid.resolution, 1e-6) << "column " << column;
    EXPECT_NEAR(caster.cast(p, pi, 30.0), 50 * grid.resolution, 1e-6) << "column " << column;
  }
}

TEST(RayCaster, PassesUnknownCells) {
  OccupancyGrid grid = box_room(0.1);
  for (Cell& cell : grid.cells) {
    if (cell == Cell::kFree) cell = Cell::kUnknown;
  }
  EXPECT_NEAR(RayCaster(grid).cast({5.0, 4.0}, 0.0, 30.0), 5.0, 1e-6);
}

TEST(RayCaster, FindsNothingBeyondItsRange) {
  const RayCaster caster(box_room(0.05));
  EXPECT_EQ(caster.cast({4.0, 3.0}, 0.0, 5.9), std::numeric_limits<double>::infinity());
}

TEST(RayCaster, FindsNothingInAGridWithoutWalls) {
  OccupancyGrid grid = box_room(0.1);
  grid.cells.assign(grid.cells.size(), Cell::kFree);
  const RayCaster caster(grid);
  EXPECT_EQ(caster.cast({4.0, 3.0}, 0.3, 100.0), std::numeric_limits<double>::infinity());
}

TEST(RayCaster, FindsNothingFromOutsideTheGrid) {
  const RayCaster caster(box_room(0.05));
  EXPECT_EQ(caster.cast({-3.0, 3.0}, 0.0, 30.0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(caster.clearance({-3.0, 3.0}), 0.0);
}

TEST(RayCaster, FindsNothingInAnEmptyGrid) {
  const RayCaster caster{OccupancyGrid{}};
  EXPECT_EQ(caster.cast({0.0, 0.0}, 0.0, 30.0), std::numeric_limits<double>::infinity());
}

TEST(RayCaster, MovesWithTheMap) {
  const OccupancyGrid grid = box_room(0.05);
  OccupancyGrid moved = grid;
  const Pose2 T{12.0, -7.0, 2.5};
  moved.T_map_grid = T * grid.T_map_grid;
  const Point2 p{3.3, 2.2};
  EXPECT_NEAR(RayCaster(moved).cast(T * p, 0.4 + T.yaw, 30.0), RayCaster(grid).cast(p, 0.4, 30.0),
              1e-6);
  EXPECT_NEAR(RayCaster(moved).clearance(T * p), RayCaster(grid).clearance(p), 1e-6);
}

TEST(RayCaster, KnowsTheClearanceToACell) {
  const RayCaster caster(box_room(0.05));
  EXPECT_NEAR(caster.clearance({5.0, 1.0}), 1.0, 0.05);
  EXPECT_EQ(caster.clearance({5.0, -0.02}), 0.0);
}

TEST(RayCaster, ScansWithTheGeometryOfTheLidar) {
  const RayCaster caster(box_room(0.05));
  LaserScan lidar;
  lidar.angle_min = -pi / 2.0;
  lidar.angle_increment = pi / 2.0;
  lidar.range_max = 5.5;
  const LaserScan scan = caster.scan(lidar, 3, {4.0, 3.0, pi / 2.0});
  ASSERT_EQ(scan.ranges.size(), 3U);
  EXPECT_TRUE(std::isnan(scan.ranges[0]));  // 6 m to the right.
  EXPECT_NEAR(scan.ranges[1], 5.0, 1e-5);
  EXPECT_NEAR(scan.ranges[2], 4.0, 1e-5);
}

}  // namespace
}  // namespace cornerfix

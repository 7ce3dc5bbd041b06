#include "core/src/map/occupancy_mapping.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>

#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::SceneBuilder;

using std::numbers::pi;
constexpr double kCellSize = 0.05;
const Point2 kSize(6.0, 4.0);
const Pose2 kMappingPoses[] = {{1.0, 1.0, 0.3},  {3.0, 1.0, 2.0}, {5.0, 1.2, -1.0},
                               {1.0, 3.0, -2.5}, {3.1, 2.9, 0.0}, {4.9, 3.1, 1.1}};

SceneBuilder plain_room() { return SceneBuilder().room({0, 0}, kSize); }

std::vector<PosedScan> scans_of(const SceneBuilder& scene, std::span<const Pose2> poses,
                                double noise_m = 0.0, const Pose2& T_base_link_laser = {}) {
  const testing::Lidar lidar{.beams = 1080, .noise_m = noise_m};
  std::mt19937_64 random(1);
  std::vector<PosedScan> scans;
  for (const Pose2& pose : poses) {
    scans.push_back({testing::simulate_scan(scene, lidar, pose * T_base_link_laser, random),
                     T_base_link_laser, pose});
  }
  return scans;
}

Cell at(const OccupancyGrid& grid, const Point2& p_map) {
  return grid.at(grid.cell_of(inverse(grid.T_map_grid) * p_map));
}

bool wall_near(const OccupancyGrid& grid, const Point2& p_map, int cells) {
  const CellIndex here = grid.cell_of(inverse(grid.T_map_grid) * p_map);
  for (int row = -cells; row <= cells; ++row) {
    for (int column = -cells; column <= cells; ++column) {
      if (grid.at({here.column + column, here.row + row}) == Cell::kOccupied) return true;
    }
  }
  return false;
}

std::size_t count(const OccupancyGrid& grid, Cell wanted) {
  return static_cast<std::size_t>(std::count(grid.cells.begin(), grid.cells.end(), wanted));
}

/// From the border of the room; positive inside.
double depth(const Point2& p) {
  return std::min({p.x(), p.y(), kSize.x() - p.x(), kSize.y() - p.y()});
}

/// Calls `check(centre in map, cell)` for all cells.
template <typename Check>
void for_each_cell(const OccupancyGrid& grid, const Check& check) {
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      check(grid.T_map_grid * grid.center({column, row}), grid.at({column, row}));
    }
  }
}

TEST(OccupancyMapping, WallsStandWhereTheyAre) {
  const OccupancyGrid grid = build_occupancy_grid(scans_of(plain_room(), kMappingPoses, 0.01), {});
  for_each_cell(grid, [](const Point2& p, Cell cell) {
    if (cell != Cell::kOccupied) return;
    EXPECT_LT(std::abs(depth(p)), 1.5 * kCellSize) << p.transpose();
  });
}

TEST(OccupancyMapping, WallsHaveNoGaps) {
  const OccupancyGrid grid = build_occupancy_grid(scans_of(plain_room(), kMappingPoses, 0.01), {});
  const SceneBuilder scene = plain_room();
  for (const testing::Wall& wall : scene.walls()) {
    for (int i = 1; i < 100; ++i) {
      const Point2 p = wall.a + (wall.b - wall.a) * (i / 100.0);
      EXPECT_TRUE(wall_near(grid, p, 1)) << p.transpose();
    }
  }
}

TEST(OccupancyMapping, WallsAreOneOrTwoCellsThick) {
  const OccupancyGrid grid = build_occupancy_grid(scans_of(plain_room(), kMappingPoses, 0.01), {});
  const auto thickness = [&](const Point2& on_wall, const Point2& across) {
    int cells = 0;
    for (int i = -6; i <= 6; ++i) {
      cells += at(grid, on_wall + i * kCellSize * across) == Cell::kOccupied ? 1 : 0;
    }
    return cells;
  };
  for (double x = 0.42; x < 5.6; x += 0.1) {
    EXPECT_THAT(thickness({x, 0.001}, {0, 1}), ::testing::AllOf(::testing::Ge(1), ::testing::Le(2)))
        << "x " << x;
    EXPECT_THAT(thickness({x, kSize.y() + 0.001}, {0, 1}),
                ::testing::AllOf(::testing::Ge(1), ::testing::Le(2)))
        << "x " << x;
  }
}

TEST(OccupancyMapping, IsFreeInsideTheRoom) {
  const OccupancyGrid grid = build_occupancy_grid(scans_of(plain_room(), kMappingPoses), {});
  for_each_cell(grid, [](const Point2& p, Cell cell) {
    if (depth(p) < 3.0 * kCellSize) return;
    EXPECT_EQ(cell, Cell::kFree) << p.transpose();
  });
}

TEST(OccupancyMapping, IsUnknownOutsideTheRoom) {
  const OccupancyGrid grid = build_occupancy_grid(scans_of(plain_room(), kMappingPoses), {});
  std::size_t outside = 0;
  for_each_cell(grid, [&](const Point2& p, Cell cell) {
    if (depth(p) > -2.0 * kCellSize) return;
    EXPECT_EQ(cell, Cell::kUnknown) << p.transpose();
    ++outside;
  });
  EXPECT_GT(outside, 0U);
}

TEST(OccupancyMapping, WhatIsBehindAPillarIsUnknown) {
  const SceneBuilder scene = plain_room().box({3.0, 2.0}, {0.6, 0.6});
  const OccupancyGrid grid = build_occupancy_grid(scans_of(scene, kMappingPoses), {});
  EXPECT_EQ(at(grid, {3.0, 2.0}), Cell::kUnknown);
}

/// Who stands where nine of ten scans look through is no part of the building.
TEST(OccupancyMapping, APersonSeenOnceIsNoWall) {
  const Point2 person(3.0, 2.0);
  std::vector<PosedScan> scans;
  for (int i = 0; i < 10; ++i) {
    const Pose2 pose[] = {{1.0, 1.0 + 0.2 * i, 0.0}};
    const SceneBuilder scene = i == 4 ? plain_room().box(person, {0.4, 0.4}, 0.3) : plain_room();
    scans.push_back(scans_of(scene, pose).front());
  }
  const OccupancyGrid grid = build_occupancy_grid(scans, {});
  EXPECT_FALSE(wall_near(grid, person, 6));
  EXPECT_EQ(at(grid, person), Cell::kFree);
}

TEST(OccupancyMapping, ScansWithoutReturnsLeaveAllUnknown) {
  PosedScan scan{{.angle_min = -pi,
                  .angle_increment = 0.01,
                  .range_min = 0.1,
                  .range_max = 30.0,
                  .ranges = {}},
                 {},
                 {2.0, 3.0, 1.0}};
  scan.scan.ranges.assign(600, std::numeric_limits<float>::quiet_NaN());
  const OccupancyGrid grid = build_occupancy_grid(std::vector{scan}, {});
  EXPECT_EQ(count(grid, Cell::kUnknown), grid.cells.size());
  EXPECT_TRUE(grid.contains(grid.cell_of(inverse(grid.T_map_grid) * Point2(2.0, 3.0))));
}

TEST(OccupancyMapping, AScanWithoutBeamsIsNoHarm) {
  const OccupancyGrid grid = build_occupancy_grid(std::vector<PosedScan>(3), {});
  EXPECT_EQ(count(grid, Cell::kUnknown), grid.cells.size());
}

TEST(OccupancyMapping, NothingGivesAnEmptyGrid) {
  const OccupancyGrid grid = build_occupancy_grid({}, {.resolution_m = 0.1});
  EXPECT_EQ(grid.width, 0);
  EXPECT_EQ(grid.height, 0);
  EXPECT_TRUE(grid.cells.empty());
  EXPECT_EQ(grid.resolution, 0.1);
}

TEST(OccupancyMapping, LeavesOutWhatIsBeyondMaxRange) {
  const Pose2 pose[] = {{1.0, 2.0, 0.0}};
  const std::vector<PosedScan> scans = scans_of(plain_room(), pose);
  const OccupancyMappingParams near{.max_range_m = 3.0};
  EXPECT_LT(bounds_of(scans.front(), near).max.x(), 4.01);
  const OccupancyGrid grid = build_occupancy_grid(scans, near);
  EXPECT_TRUE(wall_near(grid, {0.0, 2.0}, 1));
  EXPECT_FALSE(wall_near(grid, {6.0, 2.0}, 3));
  EXPECT_TRUE(wall_near(build_occupancy_grid(scans, {}), {6.0, 2.0}, 1));
}

TEST(OccupancyMapping, LiesOnWholeCellsOfTheMap) {
  for (const double resolution : {0.02, 0.05, 0.11, 0.3}) {
    const OccupancyGrid grid =
        build_occupancy_grid(scans_of(plain_room(), kMappingPoses), {.resolution_m = resolution});
    EXPECT_EQ(grid.T_map_grid.yaw, 0.0);
    EXPECT_NEAR(std::remainder(grid.T_map_grid.x, resolution), 0.0, 1e-9);
    EXPECT_NEAR(std::remainder(grid.T_map_grid.y, resolution), 0.0, 1e-9);
    EXPECT_EQ(grid.cells.size(), static_cast<std::size_t>(grid.width * grid.height));
    EXPECT_TRUE(wall_near(grid, {6.0, 2.0}, 1)) << resolution;
    EXPECT_EQ(at(grid, {3.0, 2.0}), Cell::kFree) << resolution;
  }
}

TEST(OccupancyMapping, MovingThePosesByWholeCellsMovesTheGrid) {
  const std::vector<PosedScan> scans = scans_of(plain_room(), kMappingPoses);
  std::vector<PosedScan> moved = scans;
  for (PosedScan& scan : moved) {
    scan.T_map_base_link.x += 128.0;
    scan.T_map_base_link.y -= 64.0;
  }
  const OccupancyMappingParams params{.resolution_m = 0.0625};  // so that moving rounds nothing
  const OccupancyGrid here = build_occupancy_grid(scans, params);
  const OccupancyGrid there = build_occupancy_grid(moved, params);
  ASSERT_EQ(there.width, here.width);
  ASSERT_EQ(there.height, here.height);
  EXPECT_DOUBLE_EQ(there.T_map_grid.x, here.T_map_grid.x + 128.0);
  EXPECT_DOUBLE_EQ(there.T_map_grid.y, here.T_map_grid.y - 64.0);
  std::size_t different = 0;
  for (std::size_t i = 0; i < here.cells.size(); ++i) {
    different += here.cells[i] == there.cells[i] ? 0 : 1;
  }
  EXPECT_LT(different, here.cells.size() / 200);  // a beam along a cell border may fall either way
}

TEST(OccupancyMapping, TheOrderOfTheScansChangesNothing) {
  std::vector<PosedScan> scans = scans_of(plain_room(), kMappingPoses, 0.01);
  const OccupancyGrid forward = build_occupancy_grid(scans, {});
  std::reverse(scans.begin(), scans.end());
  EXPECT_EQ(build_occupancy_grid(scans, {}), forward);
}

/// Two drives through the room, a day apart.
std::vector<PosedScan> mapped_again(const SceneBuilder& before, const SceneBuilder& after,
                                    std::span<const Pose2> poses_after, double noise_m = 0.01,
                                    const Pose2& T_map_told = {}) {
  std::vector<PosedScan> scans;
  for (int pass = 0; pass < 10; ++pass) {
    for (PosedScan& scan : scans_of(before, kMappingPoses, noise_m))
      scans.push_back(std::move(scan));
  }
  for (PosedScan& scan : scans_of(after, poses_after, noise_m)) {
    scan.scan.stamp = 86400.0;
    scan.T_map_base_link = T_map_told * scan.T_map_base_link;
    scans.push_back(std::move(scan));
  }
  return scans;
}

const Point2 kPillar(3.0, 2.0);
SceneBuilder room_with_pillar() { return plain_room().box(kPillar, {0.6, 0.6}); }

TEST(OccupancyMapping, WhatALaterDriveLooksThroughIsFreeHoweverOftenItWasSeen) {
  const OccupancyGrid grid =
      build_occupancy_grid(mapped_again(room_with_pillar(), plain_room(), kMappingPoses), {});
  for_each_cell(grid, [](const Point2& p, Cell cell) {
    if (depth(p) < 3.0 * kCellSize) return;
    EXPECT_EQ(cell, Cell::kFree) << p.transpose();
  });
}

TEST(OccupancyMapping, OneDriveAloneForgetsNothing) {
  std::vector<PosedScan> scans = mapped_again(room_with_pillar(), plain_room(), kMappingPoses);
  for (PosedScan& scan : scans) scan.scan.stamp = 0.0;
  EXPECT_TRUE(wall_near(build_occupancy_grid(scans, {}), kPillar + Point2(0.3, 0.0), 1));
}

TEST(OccupancyMapping, WhatALaterDriveFindsStandsHoweverOftenItWasFree) {
  const OccupancyGrid grid =
      build_occupancy_grid(mapped_again(plain_room(), room_with_pillar(), kMappingPoses), {});
  for (const Point2& face : {Point2(0.3, 0.0), Point2(-0.3, 0.0), Point2(0.0, 0.3)}) {
    EXPECT_TRUE(wall_near(grid, kPillar + face, 1)) << face.transpose();
  }
}

TEST(OccupancyMapping, WhatALaterDriveDoesNotSeeStays) {
  // From one corner, with a wall across: the far part of the room is out of sight.
  const Pose2 pose[] = {{1.0, 1.0, 0.3}};
  const SceneBuilder divided = plain_room().wall({1.5, 0.0}, {1.5, 4.0});
  const OccupancyGrid before =
      build_occupancy_grid(scans_of(room_with_pillar(), kMappingPoses), {});
  const OccupancyGrid after =
      build_occupancy_grid(mapped_again(room_with_pillar(), divided, pose, 0.0), {});
  for_each_cell(before, [&](const Point2& p, Cell cell) {
    if (p.x() < 1.5 + 2.5 * kCellSize) return;
    EXPECT_EQ(at(after, p), cell) << p.transpose();
  });
  EXPECT_TRUE(wall_near(after, {1.5, 2.0}, 1));
}

/// Someone who walks by, mixed pixels: a beam that ends where many passed.
TEST(OccupancyMapping, SingleBeamsOfALaterDriveMakeNoWall) {
  std::vector<PosedScan> scans = mapped_again(plain_room(), plain_room(), {}, 0.0);
  PosedScan stray = scans_of(plain_room(), std::span(kMappingPoses).first(1)).front();
  stray.scan.stamp = 86400.0;
  for (std::size_t beam = 0; beam < stray.scan.ranges.size(); ++beam) {
    stray.scan.ranges[beam] *= beam % 40 == 0 ? 0.5F : std::numeric_limits<float>::quiet_NaN();
  }
  const OccupancyGrid before = build_occupancy_grid(scans, {});
  scans.push_back(stray);
  EXPECT_EQ(build_occupancy_grid(scans, {}).cells, before.cells);
}

TEST(OccupancyMapping, WallsDoNotGrowThickWhenALaterDriveIsOffByACell) {
  const Pose2 T_map_told{0.04, -0.03, 0.002};
  const OccupancyGrid once = build_occupancy_grid(scans_of(plain_room(), kMappingPoses, 0.01), {});
  const OccupancyGrid twice = build_occupancy_grid(
      mapped_again(plain_room(), plain_room(), kMappingPoses, 0.01, T_map_told), {});
  EXPECT_LT(static_cast<double>(count(twice, Cell::kOccupied)),
            1.15 * static_cast<double>(count(once, Cell::kOccupied)));
  for_each_cell(twice, [](const Point2& p, Cell cell) {
    if (cell != Cell::kOccupied) return;
    EXPECT_LT(std::abs(depth(p)), 0.06 + 1.5 * kCellSize) << p.transpose();
  });
}

TEST(OccupancyMapping, KnowsWhereTheLaserIsMounted) {
  const Pose2 T_base_link_laser{0.3, -0.2, pi / 2.0};
  const OccupancyGrid grid =
      build_occupancy_grid(scans_of(plain_room(), kMappingPoses, 0.0, T_base_link_laser), {});
  for_each_cell(grid, [](const Point2& p, Cell cell) {
    if (cell != Cell::kOccupied) return;
    EXPECT_LT(std::abs(depth(p)), 1.5 * kCellSize) << p.transpose();
  });
  EXPECT_TRUE(wall_near(grid, {6.0, 2.0}, 1));
}

TEST(OccupancyMapping, BoundsHoldTheRobotAndWhatItSaw) {
  const Pose2 pose[] = {{1.0, 2.0, 0.7}};
  const Bounds bounds = bounds_of(scans_of(plain_room(), pose).front(), {});
  EXPECT_NEAR(bounds.min.x(), 0.0, 1e-3);
  EXPECT_NEAR(bounds.min.y(), 0.0, 1e-3);
  EXPECT_NEAR(bounds.max.x(), 6.0, 1e-3);
  EXPECT_NEAR(bounds.max.y(), 4.0, 1e-3);
}

TEST(OccupancyMapping, RefusesParamsOutsideTheirLimits) {
  EXPECT_FALSE(validate(OccupancyMappingParams{}).has_value());
  const auto field_of = [](OccupancyMappingParams params) {
    const auto error = validate(params);
    return error ? error->field : "";
  };
  const double nan = std::nan("");
  EXPECT_EQ(field_of({.resolution_m = 0.0}), "resolution_m");
  EXPECT_EQ(field_of({.resolution_m = nan}), "resolution_m");
  EXPECT_EQ(field_of({.max_range_m = 0.0}), "max_range_m");
  EXPECT_EQ(field_of({.max_range_m = nan}), "max_range_m");
  EXPECT_EQ(field_of({.min_peak_share = 1.1}), "min_peak_share");
  EXPECT_EQ(field_of({.min_hit_share = -0.1}), "min_hit_share");
}

}  // namespace
}  // namespace cornerfix

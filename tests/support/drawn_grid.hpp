/// \file  Scenes drawn into occupancy grids, without any scan.
#pragma once

#include <cmath>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>

#include "support/scene_builder.hpp"

namespace cornerfix::testing {

/// An unknown grid of `size_m`.
[[nodiscard]] inline OccupancyGrid unknown_grid(const Pose2& T_map_grid, const Point2& size_m,
                                                double resolution) {
  OccupancyGrid grid;
  grid.resolution = resolution;
  grid.T_map_grid = T_map_grid;
  grid.width = static_cast<int>(std::ceil(size_m.x() / resolution));
  grid.height = static_cast<int>(std::ceil(size_m.y() / resolution));
  grid.cells.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                    Cell::kUnknown);
  return grid;
}

/// Occupies the cells that the walls of a scene run through.
inline void draw_walls(OccupancyGrid& grid, const SceneBuilder& scene) {
  const Pose2 T_grid_map = inverse(grid.T_map_grid);
  for (const Wall& wall : scene.walls()) {
    const Point2 a = T_grid_map * wall.a;
    const Point2 b = T_grid_map * wall.b;
    const int pieces = 1 + static_cast<int>((b - a).norm() / (0.2 * grid.resolution));
    for (int i = 0; i <= pieces; ++i) {
      const CellIndex cell = grid.cell_of(a + (b - a) * (static_cast<double>(i) / pieces));
      if (grid.contains(cell)) grid.cells[grid.offset(cell)] = Cell::kOccupied;
    }
  }
}

/// Frees all unknown cells that are joined to the one at `inside_map`.
inline void free_from(OccupancyGrid& grid, const Point2& inside_map) {
  std::vector<CellIndex> open{grid.cell_of(inverse(grid.T_map_grid) * inside_map)};
  while (!open.empty()) {
    const CellIndex cell = open.back();
    open.pop_back();
    if (!grid.contains(cell) || grid.at(cell) != Cell::kUnknown) continue;
    grid.cells[grid.offset(cell)] = Cell::kFree;
    open.push_back({cell.column - 1, cell.row});
    open.push_back({cell.column + 1, cell.row});
    open.push_back({cell.column, cell.row - 1});
    open.push_back({cell.column, cell.row + 1});
  }
}

/// The walls of a scene; free where one can get to from `inside_map`, unknown elsewhere.
[[nodiscard]] inline OccupancyGrid drawn_grid(const SceneBuilder& scene, const Point2& inside_map,
                                              const Pose2& T_map_grid, const Point2& size_m,
                                              double resolution) {
  OccupancyGrid grid = unknown_grid(T_map_grid, size_m, resolution);
  draw_walls(grid, scene);
  free_from(grid, inside_map);
  return grid;
}

}  // namespace cornerfix::testing

/// \file  A floor plan in cells: free, occupied or unknown.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// The byte values are stored on disk (docs/storage-schema.md): never renumber them.
enum class Cell : std::uint8_t { kFree = 0, kOccupied = 1, kUnknown = 2 };

/// Index of a cell; column along x, row along y of the grid's own frame.
struct CellIndex {
  int column = 0;
  int row = 0;
  friend bool operator==(const CellIndex&, const CellIndex&) = default;
};

// What a grid that is read may have: cells of a millimetre to 100 m, an origin as far as poses.
inline constexpr double kFinestCell = 1e-3;     ///< [m]
inline constexpr double kCoarsestCell = 100.0;  ///< [m]
inline constexpr double kFarthestOrigin = 1e8;  ///< [m]

/// Row-major cells, row 0 at the lowest y. Frame `grid` has its origin at the lower left corner of
/// cell (0, 0).
struct OccupancyGrid {
  double resolution = 0.05;  ///< [m/cell]
  Pose2 T_map_grid;  ///< `origin` of a ROS map_server yaml; its yaw is zero for grids made from
                     ///< scans.
  int width = 0;     ///< Columns.
  int height = 0;    ///< Rows.
  std::vector<Cell> cells;  ///< width * height.

  [[nodiscard]] bool contains(CellIndex c) const {
    return c.column >= 0 && c.row >= 0 && c.column < width && c.row < height;
  }
  /// Cells outside are unknown.
  [[nodiscard]] Cell at(CellIndex c) const {
    return contains(c) ? cells[offset(c)] : Cell::kUnknown;
  }
  [[nodiscard]] std::size_t offset(CellIndex c) const {
    return static_cast<std::size_t>(c.row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(c.column);
  }
  /// The cell that holds a point of frame `grid`.
  [[nodiscard]] CellIndex cell_of(const Point2& point_grid) const {
    return {static_cast<int>(std::floor(point_grid.x() / resolution)),
            static_cast<int>(std::floor(point_grid.y() / resolution))};
  }
  /// Centre of a cell, in frame `grid`.
  [[nodiscard]] Point2 center(CellIndex c) const {
    return {(c.column + 0.5) * resolution, (c.row + 0.5) * resolution};
  }

  /// Area of the known-free cells [m^2]. O(cells).
  [[nodiscard]] double free_area_m2() const {
    return static_cast<double>(std::ranges::count(cells, Cell::kFree)) * resolution * resolution;
  }

  friend bool operator==(const OccupancyGrid&, const OccupancyGrid&) = default;
};

}  // namespace cornerfix

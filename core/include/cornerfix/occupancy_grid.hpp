/// \file  A floor plan in cells (free, occupied or unknown), and what a lidar would see in it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>
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

/// Where the beams of a lidar look, in its own frame, each of length 1.
[[nodiscard]] std::vector<Point2> beam_directions(const LaserScan& lidar, std::size_t beams);

/// Casts rays through a grid, by its distance transform. Immutable after construction: any threads
/// may share it.
class RayCaster {
 public:
  /// O(cells).
  explicit RayCaster(const OccupancyGrid& grid);

  /// Metres from `origin_map` along `heading_map` to the first occupied cell, or infinity when
  /// there is none within `range_max_m` or the ray leaves the grid. About 10-30 look-ups per ray.
  [[nodiscard]] double cast(const Point2& origin_map, double heading_map, double range_max_m) const;

  /// A whole scan with the geometry of `lidar` (its ranges are ignored) and `beams` beams; a beam
  /// that hits nothing is NaN.
  [[nodiscard]] LaserScan scan(const LaserScan& lidar, std::size_t beams,
                               const Pose2& T_map_laser) const {
    return scan(lidar, beam_directions(lidar, beams), T_map_laser);
  }
  /// The same with beam_directions() at hand.
  [[nodiscard]] LaserScan scan(const LaserScan& lidar, std::span<const Point2> directions_laser,
                               const Pose2& T_map_laser) const;

  /// Metres from a point to the nearest occupied cell; 0 outside the grid.
  [[nodiscard]] double clearance(const Point2& point_map) const;

 private:
  /// All in cells of the grid, `direction` of length 1; infinity where nothing is hit.
  [[nodiscard]] double cells_to_wall(const Point2& origin, const Point2& direction,
                                     double range_max_cells) const;

  Pose2 T_grid_map_;
  double resolution_ = 0.0;
  int width_ = 0;
  int height_ = 0;
  std::vector<float> distance_;  ///< From the centre of each cell to that of a wall's [cells].
};

}  // namespace cornerfix

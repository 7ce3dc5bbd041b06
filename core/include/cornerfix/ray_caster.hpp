/// \file  What a lidar would see from a pose in an occupancy grid.
#pragma once

#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/occupancy_grid.hpp>

namespace cornerfix {

/// Where the beams of a lidar look, in its own frame, each of length 1.
[[nodiscard]] std::vector<Point2> beam_directions(const LaserScan& lidar, std::size_t beams);

/// Casts rays through a grid, by its distance transform. Immutable after construction: any threads
/// may share it.
class RayCaster {
 public:
  /// O(cells).
  explicit RayCaster(const OccupancyGrid& grid);

  /// Metres from `origin_map` along `heading_map` to the first occupied cell, or infinity when
  /// there is none within `range_max_m` or the ray leaves the grid. About 10-30 look-ups a ray.
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

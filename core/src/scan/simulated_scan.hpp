/// \file  Scans that a lidar would take in the free space of an occupancy map.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/occupancy_grid.hpp>

namespace cornerfix {

/// Casts scans without noise. Immutable after construction: any threads may share it.
class SimulatedLidar {
 public:
  /// \param floor_map  Must outlive this. O(cells).
  explicit SimulatedLidar(const OccupancyGrid& floor_map);

  /// Where to scan from, in `map`: in each square of a lattice the free place farthest from all
  /// walls, if that is `clearance_m` or more. A robot must have room to move there: 1 m^2 for its
  /// middle, so that what was seen through windows does not count. O(cells).
  [[nodiscard]] std::vector<Point2> viewpoints(double lattice_m, double clearance_m) const;

  /// With the geometry of `lidar` (its ranges are ignored) and so many beams. A beam goes on
  /// through narrow gaps of the unknown but has no return from beyond 0.25 m of it.
  [[nodiscard]] LaserScan scan(const LaserScan& lidar, std::size_t beams,
                               const Pose2& T_map_laser) const {
    return scan(lidar, beam_directions(lidar, beams), T_map_laser);
  }
  /// By 1080 beams all around that see 12 m far, with the axes of `map`.
  [[nodiscard]] LaserScan scan(const Point2& viewpoint_map) const;

  /// Metres from a point to the nearest wall or to the unknown beyond it; 0 outside the occupancy
  /// map.
  [[nodiscard]] double clearance(const Point2& point_map) const {
    return caster_.clearance(point_map);
  }

 private:
  [[nodiscard]] LaserScan scan(const LaserScan& lidar, std::span<const Point2> directions_laser,
                               const Pose2& T_map_laser) const;

  const OccupancyGrid& floor_map_;
  RayCaster caster_;
  std::vector<Point2> all_around_;  ///< beam_directions() of scan(viewpoint).
};

}  // namespace cornerfix

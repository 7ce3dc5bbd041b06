/// \file  Scans that a lidar would take in the free space of a floor map.
#pragma once

#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/ray_caster.hpp>

namespace cornerfix {

/// A lidar of 1080 beams all around that sees 12 m far, without noise. Immutable after
/// construction: any threads may share it.
class VirtualLidar {
 public:
  /// \param floor_map  Must outlive this. O(cells).
  explicit VirtualLidar(const OccupancyGrid& floor_map);

  /// Where to scan from, in `map`: in each square of a lattice the free place farthest from all
  /// walls, if that is `clearance_m` or more. O(cells).
  [[nodiscard]] std::vector<Point2> viewpoints(double lattice_m, double clearance_m) const;

  /// A beam goes on through narrow gaps of the unknown but has no return from beyond 0.25 m of it.
  /// The laser's axes are those of `map`.
  [[nodiscard]] LaserScan scan(const Point2& viewpoint_map) const;

 private:
  const OccupancyGrid& floor_map_;
  RayCaster caster_;
};

}  // namespace cornerfix

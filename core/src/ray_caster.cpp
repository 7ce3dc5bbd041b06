#include <cornerfix/ray_caster.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "wall_distance.hpp"

namespace cornerfix {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A ray is moved this far past a cell's edge, so that rounding cannot leave it where it was.
constexpr double kEdgeSlackCells = 1e-6;

/// The cell that a ray goes on in, along one axis: from a grid line it looks along its direction.
double cell_ahead(double position, double direction) {
  return direction < 0.0 ? std::ceil(position) - 1.0 : std::floor(position);
}

/// Cells along a ray until it crosses the next grid line of one axis.
double cells_to_grid_line(double position, double cell, double direction) {
  if (direction > 0.0) return (cell + 1.0 - position) / direction;
  if (direction < 0.0) return (cell - position) / direction;
  return kInfinity;
}

}  // namespace

RayCaster::RayCaster(const OccupancyGrid& grid)
    : T_grid_map_(inverse(grid.T_map_grid)),
      resolution_(grid.resolution),
      width_(grid.width),
      height_(grid.height),
      distance_m_(distances_to_walls(grid)) {
  for (float& distance : distance_m_) distance *= static_cast<float>(resolution_);
}

double RayCaster::cast(const Point2& origin_map, double heading_map, double range_max_m) const {
  const Point2 origin = T_grid_map_ * origin_map / resolution_;  // In cells.
  const double heading = T_grid_map_.yaw + heading_map;
  const Point2 direction{std::cos(heading), std::sin(heading)};
  const double range_max_cells = range_max_m / resolution_;

  for (double range = 0.0; range <= range_max_cells;) {
    const Point2 position = origin + range * direction;
    const double column = cell_ahead(position.x(), direction.x());
    const double row = cell_ahead(position.y(), direction.y());
    if (column < 0.0 || row < 0.0 || column >= width_ || row >= height_) return kInfinity;
    const auto offset = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                        static_cast<std::size_t>(column);
    const double centre_distance = static_cast<double>(distance_m_[offset]) / resolution_;
    if (centre_distance == 0.0) return range * resolution_;

    // Nearer than this no wall can be: its square reaches half a diagonal about its centre.
    const double from_centre = (position - Point2{column + 0.5, row + 0.5}).norm();
    const double free_way = centre_distance - from_centre - std::numbers::sqrt2 / 2.0;
    const double to_next_cell = std::min(cells_to_grid_line(position.x(), column, direction.x()),
                                         cells_to_grid_line(position.y(), row, direction.y()));
    range += std::max(free_way, to_next_cell + kEdgeSlackCells);
  }
  return kInfinity;
}

LaserScan RayCaster::scan(const LaserScan& lidar, std::size_t beams,
                          const Pose2& T_map_laser) const {
  LaserScan scan = lidar;
  scan.ranges.resize(beams);
  for (std::size_t beam = 0; beam < beams; ++beam) {
    const double range =
        cast(T_map_laser.translation(), T_map_laser.yaw + lidar.bearing(beam), lidar.range_max);
    scan.ranges[beam] =
        std::isfinite(range) ? static_cast<float>(range) : std::numeric_limits<float>::quiet_NaN();
  }
  return scan;
}

double RayCaster::clearance(const Point2& point_map) const {
  const Point2 cell = (T_grid_map_ * point_map) / resolution_;
  const double column = std::floor(cell.x());
  const double row = std::floor(cell.y());
  if (!(column >= 0.0 && row >= 0.0 && column < width_ && row < height_)) return 0.0;
  const auto offset = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(column);
  // From centre to centre it was; the wall begins half a cell before its own.
  return std::max(0.0, static_cast<double>(distance_m_[offset]) - 0.5 * resolution_);
}

}  // namespace cornerfix

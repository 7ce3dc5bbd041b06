#include <cornerfix/occupancy_grid.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/src/scan/wall_distance.hpp"

namespace cornerfix {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A ray is moved this far past a cell's edge, so that rounding cannot leave it where it was.
constexpr double kEdgeSlackCells = 1e-6;

/// The cell that a ray goes on in, along one axis, from a place in the grid: on a grid line it
/// looks along its direction.
int cell_ahead(double position, double direction) {
  const int cell = static_cast<int>(position);
  return direction < 0.0 && cell == position ? cell - 1 : cell;
}

/// Cells along a ray until it crosses the next grid line of one axis. \param slope  1 / direction,
/// infinite when the ray runs along the grid lines.
double cells_to_grid_line(double position, int cell, double slope) {
  if (std::isinf(slope)) return kInfinity;
  return (slope > 0.0 ? cell + 1 - position : cell - position) * slope;
}

}  // namespace

std::vector<Point2> beam_directions(const LaserScan& lidar, std::size_t beams) {
  std::vector<Point2> directions;
  directions.reserve(beams);
  for (std::size_t beam = 0; beam < beams; ++beam)
    directions.emplace_back(std::cos(lidar.bearing(beam)), std::sin(lidar.bearing(beam)));
  return directions;
}

RayCaster::RayCaster(const OccupancyGrid& grid)
    : T_grid_map_(inverse(grid.T_map_grid)),
      resolution_(grid.resolution),
      width_(grid.width),
      height_(grid.height),
      distance_(distances_to_walls(grid)) {}

double RayCaster::cast(const Point2& origin_map, double heading_map, double range_max_m) const {
  const double heading = T_grid_map_.yaw + heading_map;
  return cells_to_wall(T_grid_map_ * origin_map / resolution_,
                       {std::cos(heading), std::sin(heading)}, range_max_m / resolution_) *
         resolution_;
}

double RayCaster::cells_to_wall(const Point2& origin, const Point2& direction,
                                double range_max_cells) const {
  const Point2 slope = direction.cwiseInverse();
  for (double range = 0.0; range <= range_max_cells;) {
    const Point2 position = origin + range * direction;
    const bool is_inside = position.x() >= 0.0 && position.y() >= 0.0 && position.x() <= width_ &&
                           position.y() <= height_;
    if (!is_inside) return kInfinity;
    const int column = cell_ahead(position.x(), direction.x());
    const int row = cell_ahead(position.y(), direction.y());
    if (column < 0 || row < 0 || column >= width_ || row >= height_) return kInfinity;
    const auto centre_distance = static_cast<double>(
        distance_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                  static_cast<std::size_t>(column)]);
    if (centre_distance == 0.0) return range;

    // Nearer than this no wall can be: both its square and that of this cell reach half a diagonal
    // about their centres.
    const double free_way = centre_distance - std::numbers::sqrt2;
    range += free_way > 1.0 ? free_way
                            : std::min(cells_to_grid_line(position.x(), column, slope.x()),
                                       cells_to_grid_line(position.y(), row, slope.y())) +
                                  kEdgeSlackCells;
  }
  return kInfinity;
}

LaserScan RayCaster::scan(const LaserScan& lidar, std::span<const Point2> directions_laser,
                          const Pose2& T_map_laser) const {
  const Pose2 T_grid_laser = T_grid_map_ * T_map_laser;
  const Point2 origin = T_grid_laser.translation() / resolution_;
  const double c = std::cos(T_grid_laser.yaw);
  const double s = std::sin(T_grid_laser.yaw);
  const double range_max_cells = lidar.range_max / resolution_;
  LaserScan scan = lidar;
  scan.ranges.clear();
  scan.ranges.reserve(directions_laser.size());
  for (const Point2& p : directions_laser) {
    const double cells =
        cells_to_wall(origin, {c * p.x() - s * p.y(), s * p.x() + c * p.y()}, range_max_cells);
    scan.ranges.push_back(std::isfinite(cells) ? static_cast<float>(cells * resolution_)
                                               : std::numeric_limits<float>::quiet_NaN());
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
  return std::max(0.0, static_cast<double>(distance_[offset]) - 0.5) * resolution_;
}

}  // namespace cornerfix

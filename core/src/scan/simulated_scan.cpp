#include "core/src/scan/simulated_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace cornerfix {
namespace {

constexpr std::size_t kBeams = 1080;
constexpr double kMaxUnknownWay = 0.25;  // [m]
constexpr double kLeastRoom = 1.0;       // for the middle of a robot [m^2]

LaserScan lidar_all_around() {
  return {.stamp = 0.0,
          .angle_min = -std::numbers::pi,
          .angle_increment = 2.0 * std::numbers::pi / kBeams,
          .range_min = 0.0,
          .range_max = 12.0,
          .ranges = {}};
}

/// What stops beams is occupied: walls, and the unknown away from all that is known. Some rows at a
/// time, with as many neighbours that none is missed: the distances of a large map take four times
/// its memory.
OccupancyGrid opaque(const OccupancyGrid& floor_map) {
  constexpr int kRows = 512;
  OccupancyGrid grid = floor_map;
  const auto limit = static_cast<float>(0.5 * kMaxUnknownWay / grid.resolution);
  // OpenCV takes a step to a neighbour for 0.955 cells.
  const int overlap = static_cast<int>(1.1F * limit) + 2;
  for (int first = 0; first < grid.height; first += kRows) {
    const cv::Range inner(first, std::min(grid.height, first + kRows));
    const cv::Range outer(std::max(0, inner.start - overlap),
                          std::min(grid.height, inner.end + overlap));
    cv::Mat_<std::uint8_t> unknown(outer.size(), grid.width);
    const auto* const cells = floor_map.cells.data();
    std::transform(cells + grid.offset({0, outer.start}), cells + grid.offset({0, outer.end}),
                   unknown.begin(), [](Cell cell) { return cell == Cell::kUnknown ? 255 : 0; });
    cv::Mat cells_to_known;
    cv::distanceTransform(unknown, cells_to_known, cv::DIST_L2, cv::DIST_MASK_3, CV_32F);
    for (int row = inner.start; row < inner.end; ++row) {
      const auto* distance = cells_to_known.ptr<float>(row - outer.start);
      for (int column = 0; column < grid.width; ++column) {
        Cell& cell = grid.cells[grid.offset({column, row})];
        if (cell != Cell::kUnknown) continue;
        cell = distance[column] > limit ? Cell::kOccupied : Cell::kFree;
      }
    }
  }
  return grid;
}

/// Leaves of the cells that are 1 those in regions of so many or more, as 2; others become 0.
void drop_small_regions(cv::Mat_<std::uint8_t>& cells, double least_cells) {
  const int eight_neighbours = 8;
  for (int row = 0; row < cells.rows; ++row) {
    for (int column = 0; column < cells.cols; ++column) {
      if (cells(row, column) != 1) continue;
      const cv::Point seed(column, row);
      const int count = cv::floodFill(cells, seed, 2, nullptr, {}, {}, eight_neighbours);
      if (count < least_cells) cv::floodFill(cells, seed, 0, nullptr, {}, {}, eight_neighbours);
    }
  }
}

/// Not 0 where a robot has room to move about. What beams saw of the world behind a window or a
/// door that stood ajar lies in slivers.
cv::Mat_<std::uint8_t> room_of(const OccupancyGrid& floor_map, const RayCaster& caster,
                               double clearance_m) {
  cv::Mat_<std::uint8_t> roomy(floor_map.height, floor_map.width, std::uint8_t{0});
  for (int row = 0; row < floor_map.height; ++row) {
    for (int column = 0; column < floor_map.width; ++column) {
      if (floor_map.at({column, row}) != Cell::kFree) continue;
      const Point2 point_map = floor_map.T_map_grid * floor_map.center({column, row});
      if (caster.clearance(point_map) >= clearance_m) roomy(row, column) = 1;
    }
  }
  drop_small_regions(roomy, kLeastRoom / (floor_map.resolution * floor_map.resolution));
  return roomy;
}

}  // namespace

SimulatedLidar::SimulatedLidar(const OccupancyGrid& floor_map)
    : floor_map_(floor_map),
      caster_(opaque(floor_map)),
      all_around_(beam_directions(lidar_all_around(), kBeams)) {}

std::vector<Point2> SimulatedLidar::viewpoints(double lattice_m, double clearance_m) const {
  struct Best {
    double clearance = 0.0;
    Point2 point_map = Point2::Zero();
  };
  const double lattice_cells = std::max(1.0, lattice_m / floor_map_.resolution);
  const auto square_of = [&](int cell) { return static_cast<std::size_t>(cell / lattice_cells); };
  const std::size_t columns = square_of(floor_map_.width) + 1;
  std::vector<Best> squares(columns * (square_of(floor_map_.height) + 1));
  const cv::Mat_<std::uint8_t> room = room_of(floor_map_, caster_, clearance_m);
  for (int row = 0; row < floor_map_.height; ++row) {
    for (int column = 0; column < floor_map_.width; ++column) {
      if (room(row, column) == 0) continue;
      const Point2 point_map = floor_map_.T_map_grid * floor_map_.center({column, row});
      const double clearance = caster_.clearance(point_map);
      Best& best = squares[square_of(row) * columns + square_of(column)];
      if (clearance > best.clearance) best = {clearance, point_map};
    }
  }
  std::vector<Point2> viewpoints;
  for (const Best& best : squares) {
    if (best.clearance > 0.0) viewpoints.push_back(best.point_map);
  }
  return viewpoints;
}

LaserScan SimulatedLidar::scan(const LaserScan& lidar, std::span<const Point2> directions_laser,
                               const Pose2& T_map_laser) const {
  LaserScan scan = caster_.scan(lidar, directions_laser, T_map_laser);
  const Pose2 T_grid_laser = inverse(floor_map_.T_map_grid) * T_map_laser;
  const double c = std::cos(T_grid_laser.yaw);
  const double s = std::sin(T_grid_laser.yaw);
  const double into_cell = 1e-3 * floor_map_.resolution;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.has_return(beam)) continue;
    const Point2 end =
        (static_cast<double>(scan.ranges[beam]) + into_cell) * directions_laser[beam];
    const Point2 end_grid{T_grid_laser.x + c * end.x() - s * end.y(),
                          T_grid_laser.y + s * end.x() + c * end.y()};
    if (floor_map_.at(floor_map_.cell_of(end_grid)) != Cell::kOccupied)
      scan.ranges[beam] = std::numeric_limits<float>::quiet_NaN();
  }
  return scan;
}

LaserScan SimulatedLidar::scan(const Point2& viewpoint_map) const {
  return scan(lidar_all_around(), all_around_, {viewpoint_map.x(), viewpoint_map.y(), 0.0});
}

}  // namespace cornerfix

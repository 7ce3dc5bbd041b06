#include "core/src/map/occupancy_mapping.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/src/map/beam_counts.hpp"
#include "core/src/map/mapping_drive.hpp"

namespace cornerfix {
namespace {

/// Counts the beams of one run.
class BeamCounter {
 public:
  explicit BeamCounter(const OccupancyGrid& grid) : grid_(grid), counts_(grid.cells.size()) {}

  [[nodiscard]] std::vector<BeamCounts>& counts() { return counts_; }

  void add(const PosedScan& key_frame, double max_range_m) {
    const Pose2 T_grid_laser =
        inverse(grid_.T_map_grid) * key_frame.T_map_base_link * key_frame.T_base_link_laser;
    const Point2 start = T_grid_laser.translation() / grid_.resolution;
    CellIndex last{-1, -1};
    for (std::size_t beam = 0; beam < key_frame.scan.ranges.size(); ++beam) {
      if (!key_frame.scan.has_return(beam)) continue;
      const double range = static_cast<double>(key_frame.scan.ranges[beam]);
      if (range > max_range_m) continue;
      const double heading = T_grid_laser.yaw + key_frame.scan.bearing(beam);
      const Point2 direction{std::cos(heading), std::sin(heading)};
      const double length = range / grid_.resolution;
      const Point2 end = start + length * direction;
      const CellIndex end_cell{static_cast<int>(std::floor(end.x())),
                               static_cast<int>(std::floor(end.y()))};
      if (!grid_.contains(end_cell)) continue;
      count(counts_[grid_.offset(end_cell)].hits);
      // Beams side by side that end in one cell passed the same cells: tracing one of them is
      // enough.
      if (end_cell == last) continue;
      last = end_cell;
      pass(start, direction, length - 1.5);  // a beam that ends in a wall did not pass its surface
    }
  }

 private:
  /// Steps from cell border to cell border along the ray.
  void pass(const Point2& start, const Point2& direction, double length) {
    CellIndex cell{static_cast<int>(std::floor(start.x())),
                   static_cast<int>(std::floor(start.y()))};
    const int step_column = direction.x() > 0.0 ? 1 : -1;
    const int step_row = direction.y() > 0.0 ? 1 : -1;
    constexpr double kNever = std::numeric_limits<double>::infinity();
    const double per_column = direction.x() != 0.0 ? 1.0 / std::abs(direction.x()) : kNever;
    const double per_row = direction.y() != 0.0 ? 1.0 / std::abs(direction.y()) : kNever;
    double next_column = border_distance(start.x(), cell.column, step_column) * per_column;
    double next_row = border_distance(start.y(), cell.row, step_row) * per_row;
    double travelled = 0.0;
    while (travelled < length && grid_.contains(cell)) {
      count(counts_[grid_.offset(cell)].passes);
      if (next_column < next_row) {
        travelled = next_column;
        next_column += per_column;
        cell.column += step_column;
      } else {
        travelled = next_row;
        next_row += per_row;
        cell.row += step_row;
      }
    }
  }

  static double border_distance(double position, int cell, int step) {
    return std::max(1e-9, step > 0 ? cell + 1 - position : position - cell);
  }

  const OccupancyGrid& grid_;
  std::vector<BeamCounts> counts_;
};

/// Hits and misses of each cell over all runs, later runs before earlier ones.
std::vector<BeamCounts> count_beams(std::span<const PosedScan> key_frames,
                                    const OccupancyGrid& grid, double max_range_m) {
  std::vector<BeamCounts> counts;
  for (const std::span<const PosedScan> drive : drives_of(key_frames)) {
    BeamCounter counter(grid);
    for (const PosedScan& key_frame : drive) counter.add(key_frame, max_range_m);
    if (counts.empty()) {
      counts = std::move(counter.counts());
    } else {
      outweigh(counts, counter.counts(), grid);
    }
  }
  return counts;
}

bool is_wall(std::span<const BeamCounts> counts, const OccupancyGrid& grid, CellIndex cell,
             const OccupancyMappingParams& params) {
  const BeamCounts& here = counts[grid.offset(cell)];
  if (here.hits == 0) return false;
  const double beams = static_cast<double>(here.hits) + static_cast<double>(here.passes);
  if (static_cast<double>(here.hits) < params.min_hit_share * beams) return false;
  std::uint16_t peak = here.hits;
  for (int r = std::max(0, cell.row - 1); r <= std::min(grid.height - 1, cell.row + 1); ++r) {
    for (int c = std::max(0, cell.column - 1); c <= std::min(grid.width - 1, cell.column + 1);
         ++c) {
      peak = std::max(peak, counts[grid.offset({c, r})].hits);
    }
  }
  return static_cast<double>(here.hits) >= params.min_peak_share * static_cast<double>(peak);
}

/// Turns the counts into cells.
void decide(std::span<const BeamCounts> counts, const OccupancyMappingParams& params,
            OccupancyGrid& grid) {
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      const std::size_t offset = grid.offset({column, row});
      if (is_wall(counts, grid, {column, row}, params)) {
        grid.cells[offset] = Cell::kOccupied;
      } else if (counts[offset].passes > 0) {
        grid.cells[offset] = Cell::kFree;
      }
    }
  }
}

}  // namespace

std::optional<Error> validate(const OccupancyMappingParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!(params.resolution_m >= 0.01 && params.resolution_m <= 1.0)) {
    return broken("resolution_m", "must be in [0.01, 1] m");
  }
  if (!(params.max_range_m > 0.0 && params.max_range_m <= 200.0))
    return broken("max_range_m", "must be in (0, 200] m");
  if (!(params.min_peak_share >= 0.0 && params.min_peak_share <= 1.0)) {
    return broken("min_peak_share", "must be in [0, 1]");
  }
  if (!(params.min_hit_share >= 0.0 && params.min_hit_share <= 1.0))
    return broken("min_hit_share", "must be in [0, 1]");
  return std::nullopt;
}

Bounds bounds_of(const PosedScan& scan, const OccupancyMappingParams& params) {
  const Pose2 T_map_laser = scan.T_map_base_link * scan.T_base_link_laser;
  Bounds bounds{T_map_laser.translation(), T_map_laser.translation()};
  for (std::size_t beam = 0; beam < scan.scan.ranges.size(); ++beam) {
    if (!scan.scan.has_return(beam)) continue;
    const double range = static_cast<double>(scan.scan.ranges[beam]);
    if (range > params.max_range_m) continue;
    const double heading = T_map_laser.yaw + scan.scan.bearing(beam);
    const Point2 end =
        T_map_laser.translation() + range * Point2{std::cos(heading), std::sin(heading)};
    bounds.extend({end, end});
  }
  return bounds;
}

OccupancyGrid build_occupancy_grid(std::span<const PosedScan> key_frames,
                                   const OccupancyMappingParams& params) {
  OccupancyGrid grid;
  grid.resolution = params.resolution_m;
  if (key_frames.empty()) return grid;
  Bounds bounds = bounds_of(key_frames.front(), params);
  for (const PosedScan& key_frame : key_frames) bounds.extend(bounds_of(key_frame, params));
  constexpr double kMargin = 0.5;  // room for fields around the outermost walls [m]
  const Point2 first = ((bounds.min.array() - kMargin) / params.resolution_m).floor();
  const Point2 last = ((bounds.max.array() + kMargin) / params.resolution_m).ceil();
  grid.T_map_grid = {first.x() * params.resolution_m, first.y() * params.resolution_m, 0.0};
  grid.width = static_cast<int>(last.x() - first.x());
  grid.height = static_cast<int>(last.y() - first.y());
  grid.cells.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                    Cell::kUnknown);
  decide(count_beams(key_frames, grid, params.max_range_m), params, grid);
  return grid;
}

}  // namespace cornerfix

#include "core/src/slam/submap_mosaic.hpp"

#include "core/src/map/occupancy_mapping.hpp"

namespace cornerfix {
namespace {

/// Calls `visit` with each point of one kind, in the frame of the mosaic.
template <typename Visit>
void for_each_point(std::span<const DriveSubmap> submaps, std::span<const Pose2> T_map_submap,
                    std::vector<Point2> DriveSubmap::*points, Visit visit) {
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const Pose2& T = T_map_submap[i];
    const double c = std::cos(T.yaw);
    const double s = std::sin(T.yaw);
    for (const Point2& p : submaps[i].*points)
      visit(Point2{T.x + c * p.x() - s * p.y(), T.y + s * p.x() + c * p.y()});
  }
}

OccupancyGrid compose(std::span<const DriveSubmap> submaps, std::span<const Pose2> T_map_submap) {
  Bounds bounds{T_map_submap.front().translation(), T_map_submap.front().translation()};
  for (const auto points : {&DriveSubmap::walls, &DriveSubmap::floor}) {
    for_each_point(submaps, T_map_submap, points, [&bounds](const Point2& p) {
      bounds.extend({p, p});
    });
  }
  OccupancyGrid grid;
  grid.resolution = kSubmapResolution;
  constexpr double kMargin = 0.5;  // [m]
  const Point2 corner = bounds.min.array() - kMargin;
  grid.T_map_grid = {corner.x(), corner.y(), 0.0};
  const Point2 size = (bounds.max.array() + kMargin - corner.array()) / grid.resolution;
  grid.width = static_cast<int>(std::ceil(size.x()));
  grid.height = static_cast<int>(std::ceil(size.y()));
  grid.cells.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                    Cell::kUnknown);
  const int half = static_cast<int>(std::lround(0.5 * kFloorSpacing / grid.resolution));
  for_each_point(submaps, T_map_submap, &DriveSubmap::floor, [&](const Point2& p) {
    const CellIndex middle = grid.cell_of(p - corner);
    for (int row = middle.row - half; row <= middle.row + half; ++row) {
      for (int column = middle.column - half; column <= middle.column + half; ++column)
        if (grid.contains({column, row})) grid.cells[grid.offset({column, row})] = Cell::kFree;
    }
  });
  for_each_point(submaps, T_map_submap, &DriveSubmap::walls, [&](const Point2& p) {
    grid.cells[grid.offset(grid.cell_of(p - corner))] = Cell::kOccupied;
  });
  return grid;
}

}  // namespace

SubmapMosaic::SubmapMosaic(std::span<const DriveSubmap> submaps,
                           std::span<const Pose2> T_map_submap)
    : SubmapMosaic(compose(submaps, T_map_submap)) {}

SubmapMosaic::SubmapMosaic(const OccupancyGrid& grid)
    : field_(grid),
      classes_(grid, field_),
      place_search_(classes_),
      free_area_m2_(grid.free_area_m2()) {}

}  // namespace cornerfix

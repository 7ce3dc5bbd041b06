#include <cornerfix/mapper.hpp>

#include <algorithm>
#include <cstdio>
#include <span>
#include <utility>

#include "core/src/base/in_parallel.hpp"
#include "core/src/features/feature_map.hpp"
#include "core/src/map/wall_surfaces.hpp"
#include "core/src/scan/simulated_scan.hpp"

namespace cornerfix {
namespace {

constexpr double kLattice = 1.0;              // [m]
constexpr double kViewpointClearance = 0.25;  // [m]
// Walls in cells are stairs; what they differ by from straight ones counts as noise of the ranges.
constexpr double kNoisePerCell = 0.3;
constexpr double kThickWall = 0.15;  // [m], and so many cells
constexpr double kThickWallCells = 4.0;
constexpr double kCoarseCell = 0.15;  // [m]

bool has_cell(const OccupancyGrid& grid, Cell cell) {
  return std::find(grid.cells.begin(), grid.cells.end(), cell) != grid.cells.end();
}

std::vector<Feature> features_of(const SimulatedLidar& lidar, std::span<const Point2> viewpoints,
                                 double noise_m, const MapperParams& params) {
  std::vector<std::vector<Feature>> corners(viewpoints.size());
  for_each_in_parallel(viewpoints.size(), [&](std::size_t i) {
    const Point2& viewpoint = viewpoints[i];
    corners[i] = extract_corners(lidar.scan(viewpoint), params.extractor, noise_m);
    for (Feature& corner : corners[i])
      corner = transformed({viewpoint.x(), viewpoint.y(), 0.0}, corner);
  });
  FeatureMap features(params.features);
  for (const std::vector<Feature>& seen : corners) features.insert(seen);
  return features.repeated(params.min_feature_count);
}

std::string metres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f m", value);
  return text;
}

std::vector<std::string> warnings_for(const OccupancyGrid& floor_map,
                                      const WallSurfaces& surfaces) {
  std::vector<std::string> warnings;
  const double thickness = surfaces.median_thickness_m;
  if (thickness >= kThickWall && thickness >= kThickWallCells * floor_map.resolution) {
    warnings.push_back("walls are " + metres(thickness) +
                       " thick: their border to free space is taken for what a lidar sees; if the "
                       "walls were thickened, draw them as thin as they are");
  }
  if (floor_map.resolution > kCoarseCell) {
    warnings.push_back("a cell is " + metres(floor_map.resolution) +
                       " wide: poses will be about as coarse, and small corners are missing");
  }
  return warnings;
}

}  // namespace

Result<GridMap> map_from_grid(const OccupancyGrid& floor_map, const MapperParams& params) {
  if (floor_map.resolution < kFinestCell || floor_map.resolution > kCoarsestCell) {
    return Error{ErrorCode::kInvalidArgument, "expected metres a cell from 0.001 to 100",
                 "resolution"};
  }
  if (!has_cell(floor_map, Cell::kFree)) {
    return Error{ErrorCode::kInvalidArgument, "the floor map has no free cell", "image"};
  }
  if (!has_cell(floor_map, Cell::kOccupied)) {
    return Error{ErrorCode::kInvalidArgument, "the floor map has no occupied cell", "image"};
  }
  const OccupancyGrid clear = without_grey_rims(floor_map);
  Result<WallSurfaces> surfaces =
      find_wall_surfaces(clear, params.grid.resolution_m, Mapper::kMaxCells);
  if (!surfaces) return surfaces.error();
  GridMap map;
  map.warnings = warnings_for(floor_map, *surfaces);
  const SimulatedLidar lidar(clear);
  const std::vector<Point2> viewpoints = lidar.viewpoints(kLattice, kViewpointClearance);
  if (viewpoints.empty()) {
    map.warnings.push_back(
        "nowhere in the free space has a robot room to move about: the map is without features. "
        "Are "
        "resolution and thresholds right?");
  }
  map.content.features =
      features_of(lidar, viewpoints, kNoisePerCell * floor_map.resolution, params);
  map.content.descriptors = describe(map.content.features, params.descriptors);
  map.content.grid = std::move(surfaces->grid);
  return map;
}

}  // namespace cornerfix

#include <cornerfix/mapper.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "core/src/base/in_parallel.hpp"
#include "core/src/features/feature_map.hpp"
#include "core/src/map/wall_surfaces.hpp"
#include "core/src/scan/simulated_scan.hpp"

namespace cornerfix {
namespace {

constexpr double kLattice = 1.0;                // [m]
constexpr double kViewpointClearance = 0.25;    // [m]
constexpr std::size_t kMaxViewpoints = 40'000;  // 1 to 5 ms of processor time each
// Pieces of wall in an occupancy map that is noise: more than any building has.
constexpr std::int64_t kManyPieces = 5'000;
constexpr double kPiecesOfNoise = 2.0;  // [1/m^2] of free space
// Walls in cells are stairs; what they differ by from straight ones counts as noise of the ranges.
constexpr double kNoisePerCell = 0.3;
/// Whose corners are kept in memory until they are in the map, and progress is reported.
constexpr std::size_t kViewpointsAtOnce = 512;
constexpr double kThickWall = 0.15;  // [m], and so many cells
constexpr double kThickWallCells = 4.0;
constexpr double kCoarseCell = 0.15;  // [m]

bool has_cell(const OccupancyGrid& grid, Cell cell) {
  return std::find(grid.cells.begin(), grid.cells.end(), cell) != grid.cells.end();
}

/// Pieces of wall that are not connected, less the holes in them: by the Euler number of the
/// occupied cells (Gray 1971), from counts of all 2 x 2 cells.
std::int64_t wall_pieces(const OccupancyGrid& grid) {
  std::int64_t sum = 0;
  for (int row = -1; row < grid.height; ++row) {
    for (int column = -1; column < grid.width; ++column) {
      const auto is_wall = [&](int columns_off, int rows_off) {
        return grid.at({column + columns_off, row + rows_off}) == Cell::kOccupied;
      };
      const std::array<bool, 4> walls{is_wall(0, 0), is_wall(1, 0), is_wall(0, 1), is_wall(1, 1)};
      const auto count = std::ranges::count(walls, true);
      const bool is_diagonal = count == 2 && walls[0] == walls[3];
      if (count == 1) ++sum;
      if (count == 3) --sum;
      if (is_diagonal) sum -= 2;
    }
  }
  return sum / 4;
}

std::optional<Error> check_no_noise(const OccupancyGrid& grid) {
  const auto free_cells = static_cast<double>(std::ranges::count(grid.cells, Cell::kFree));
  const double free_area_m2 = free_cells * grid.resolution * grid.resolution;
  const std::int64_t pieces = wall_pieces(grid);
  const bool is_noise =
      pieces > kManyPieces && static_cast<double>(pieces) > kPiecesOfNoise * free_area_m2;
  if (!is_noise) return std::nullopt;
  return Error{ErrorCode::kInvalidArgument,
               "the walls are " + std::to_string(pieces) + " separate pieces in " +
                   std::to_string(static_cast<std::int64_t>(free_area_m2)) +
                   " m^2 of free space, expected at most 2 per m^2: is this noise? Check "
                   "resolution and thresholds",
               "image"};
}

/// One to a square of the lattice, which is wider in the largest maps.
std::vector<Point2> viewpoints_in(const OccupancyGrid& floor_map, const SimulatedLidar& lidar) {
  constexpr double kMostSquares = 10.0 * kMaxViewpoints;  // most without free space
  const double area_m2 =
      static_cast<double>(floor_map.cells.size()) * floor_map.resolution * floor_map.resolution;
  const double lattice_m = std::max(kLattice, std::sqrt(area_m2 / kMostSquares));
  std::vector<Point2> viewpoints = lidar.viewpoints(lattice_m, kViewpointClearance);
  if (viewpoints.size() <= kMaxViewpoints) return viewpoints;
  const double surplus =
      static_cast<double>(viewpoints.size()) / static_cast<double>(kMaxViewpoints);
  return lidar.viewpoints(lattice_m * std::sqrt(surplus), kViewpointClearance);
}

/// Nothing when `progress` gives up.
std::optional<std::vector<Feature>> features_of(const SimulatedLidar& lidar,
                                                std::span<const Point2> viewpoints, double noise_m,
                                                const MapperParams& params,
                                                const GridMapProgress& progress) {
  FeatureMap features(params.features);
  const std::size_t all = viewpoints.size();
  while (!viewpoints.empty()) {
    const double share = 1.0 - static_cast<double>(viewpoints.size()) / static_cast<double>(all);
    if (progress && !progress(GridMapStage::kFeatures, share)) return std::nullopt;
    const auto batch = viewpoints.first(std::min(viewpoints.size(), kViewpointsAtOnce));
    viewpoints = viewpoints.subspan(batch.size());
    std::vector<std::vector<Feature>> corners(batch.size());
    for_each_in_parallel(batch.size(), [&](std::size_t i) {
      const Point2& viewpoint = batch[i];
      corners[i] = extract_corners(lidar.scan(viewpoint), params.extractor, noise_m);
      for (Feature& corner : corners[i])
        corner = transformed({viewpoint.x(), viewpoint.y(), 0.0}, corner);
    });
    for (const std::vector<Feature>& seen : corners) features.insert(seen);
  }
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

std::optional<Error> check_grid(const OccupancyGrid& floor_map) {
  if (floor_map.resolution < kFinestCell || floor_map.resolution > kCoarsestCell) {
    return Error{ErrorCode::kInvalidArgument, "expected metres a cell from 0.001 to 100",
                 "resolution"};
  }
  if (!has_cell(floor_map, Cell::kFree)) {
    return Error{ErrorCode::kInvalidArgument,
                 "the floor map has no free cell: check free_thresh, negate and mode; transparent "
                 "pixels are unknown",
                 "image"};
  }
  if (!has_cell(floor_map, Cell::kOccupied)) {
    return Error{ErrorCode::kInvalidArgument,
                 "the floor map has no occupied cell: check occupied_thresh, negate and mode",
                 "image"};
  }
  return check_no_noise(floor_map);
}

Error given_up() { return {ErrorCode::kUnavailable, "the map's making was given up", ""}; }

}  // namespace

Result<GridMap> map_from_grid(const OccupancyGrid& floor_map, const MapperParams& params,
                              const GridMapProgress& progress) {
  const auto begin = [&](GridMapStage stage) { return !progress || progress(stage, 0.0); };
  if (!begin(GridMapStage::kWalls)) return given_up();
  if (auto error = check_grid(floor_map)) return *error;
  const OccupancyGrid clear = without_grey_rims(floor_map);
  Result<WallSurfaces> surfaces =
      find_wall_surfaces(clear, params.grid.resolution_m, Mapper::kMaxCells);
  if (!surfaces) return surfaces.error();
  GridMap map;
  map.warnings = warnings_for(floor_map, *surfaces);
  if (!begin(GridMapStage::kFeatures)) return given_up();
  {  // The lidar takes five times the memory of the grid.
    const SimulatedLidar lidar(clear);
    const std::vector<Point2> viewpoints = viewpoints_in(clear, lidar);
    if (viewpoints.empty()) {
      map.warnings.emplace_back(
          "nowhere in the free space has a robot room to move about: the map is without features. "
          "Are resolution and thresholds right?");
    }
    auto features =
        features_of(lidar, viewpoints, kNoisePerCell * floor_map.resolution, params, progress);
    if (!features) return given_up();
    map.content.features = std::move(*features);
  }
  if (!begin(GridMapStage::kDescriptors)) return given_up();
  map.content.descriptors = describe(map.content.features, params.descriptors);
  map.content.grid = std::move(surfaces->grid);
  return map;
}

}  // namespace cornerfix

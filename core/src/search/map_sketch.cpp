#include <cornerfix/map_sketch.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/src/map/distance_field.hpp"
#include "core/src/map/evidence_model.hpp"
#include "core/src/search/map_index.hpp"

namespace cornerfix {
namespace {

constexpr double kSketchCell = 0.2;  // [m]

/// The level of each packed class, by the weight that the search gives to a hit there.
std::array<HitLevel, 256> levels_of_classes() {
  std::array<HitLevel, 256> levels{};
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const std::size_t end = i & 15U;
    const float weight = end < kFieldClasses ? kSearchWeights.ends[end] : kSearchWeights.ends[0];
    levels[i] = weight > 0.0F    ? HitLevel::kWall
                : weight > -0.2F ? HitLevel::kUnknown
                : weight > -0.6F ? HitLevel::kFarFree
                                 : HitLevel::kFree;
  }
  return levels;
}

/// The most likely level of a cell and of a margin of half a cell about it, because poses and
/// corners are known to about half a cell.
HitLevel pooled_level(const ClassField& classes, int column, int row, int fine_per_cell) {
  static const std::array<HitLevel, 256> kLevels = levels_of_classes();
  const int margin = fine_per_cell / 2;
  HitLevel best = HitLevel::kFree;
  const int last_row = std::min(classes.height(), (row + 1) * fine_per_cell + margin);
  const int last_column = std::min(classes.width(), (column + 1) * fine_per_cell + margin);
  for (int r = std::max(0, row * fine_per_cell - margin); r < last_row; ++r) {
    for (int c = std::max(0, column * fine_per_cell - margin); c < last_column; ++c)
      best = std::max(best, kLevels[classes.packed(c, r)]);
  }
  return best;
}

MapSketch sketch_from(std::span<const Feature> features, const ClassField& classes,
                      double free_area_m2) {
  MapSketch sketch;
  sketch.free_area_m2 = free_area_m2;
  const int fine = std::max(1, static_cast<int>(std::lround(kSketchCell / classes.resolution())));
  sketch.T_map_grid = inverse(classes.T_grid_map());
  sketch.cell_m = fine * classes.resolution();
  sketch.width = (classes.width() + fine - 1) / fine;
  sketch.height = (classes.height() + fine - 1) / fine;
  sketch.levels.resize(MapSketch::level_bytes(sketch.width, sketch.height));
  std::size_t at = 0;
  for (int row = 0; row < sketch.height; ++row) {
    for (int column = 0; column < sketch.width; ++column, ++at) {
      const auto level = static_cast<unsigned>(pooled_level(classes, column, row, fine));
      sketch.levels[at / 4] |= static_cast<std::uint8_t>(level << (2 * (at % 4)));
    }
  }
  std::vector<Feature> corners(features.begin(), features.end());
  if (corners.size() > MapSketch::kMaxCorners) {
    std::ranges::stable_sort(corners, std::ranges::greater{}, &Feature::count);
    corners.resize(MapSketch::kMaxCorners);
  }
  for (const Feature& corner : corners) {
    const Feature in_grid = transformed(classes.T_grid_map(), corner);
    sketch.corners.push_back({static_cast<float>(in_grid.position.x()),
                              static_cast<float>(in_grid.position.y()),
                              static_cast<float>(in_grid.bisector),
                              static_cast<float>(in_grid.turn_angle), in_grid.convex});
  }
  return sketch;
}

}  // namespace

MapSketch sketch_of(std::span<const Feature> features, const OccupancyGrid& grid) {
  const DistanceField field(grid);
  return sketch_from(features, ClassField(grid, field), grid.free_area_m2());
}

MapSketch sketch_of(const LocalizationMap& map) {
  return sketch_from(map.features(), map.index().classes, map.free_area_m2());
}

}  // namespace cornerfix

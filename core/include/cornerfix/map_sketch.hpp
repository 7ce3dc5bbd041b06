/// \file  What is kept of a map to rank it among thousands of maps without loading it.
///
/// A sketch holds the corners of the map and a coarse field: where a hit is likely. It is made when
/// the map is stored, takes some kilobytes, and is enough to judge a pose roughly. A pose is never
/// accepted by a sketch (docs/method/04-search.md, section 4.8).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/corners.hpp>
#include <cornerfix/localization_map.hpp>
#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// A corner in frame `grid` of its sketch.
struct SketchCorner {
  float x = 0.0F;           ///< [m]
  float y = 0.0F;           ///< [m]
  float bisector = 0.0F;    ///< As Feature::bisector [rad].
  float turn_angle = 0.0F;  ///< As Feature::turn_angle [rad].
  bool convex = false;      ///< As Feature::convex.

  friend bool operator==(const SketchCorner&, const SketchCorner&) = default;
};

/// How likely a hit is in a cell, from least to most likely.
enum class HitLevel : std::uint8_t { kFree, kFarFree, kUnknown, kWall };

struct MapSketch {
  static constexpr std::size_t kMaxCorners = 20'000;  ///< Those seen most often are kept.

  Pose2 T_map_grid;           ///< Origin at the lower left corner of the field.
  double free_area_m2 = 0.0;  ///< Known-free space.
  double cell_m = 0.0;
  int width = 0;   ///< Cells.
  int height = 0;  ///< Cells.
  /// HitLevel by cell, row by row, four cells per byte, the first one in the lowest bits.
  std::vector<std::uint8_t> levels;
  std::vector<SketchCorner> corners;

  /// Bytes that `levels` has.
  [[nodiscard]] static std::size_t level_bytes(int width, int height) {
    return (static_cast<std::size_t>(width) * static_cast<std::size_t>(height) + 3) / 4;
  }
  /// Of a cell; outside of the field it is unknown.
  [[nodiscard]] HitLevel level(int column, int row) const {
    if (column < 0 || row < 0 || column >= width || row >= height) return HitLevel::kUnknown;
    const std::size_t at = static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(column);
    return static_cast<HitLevel>((levels[at / 4] >> (2 * (at % 4))) & 3U);
  }
  /// In memory.
  [[nodiscard]] std::size_t bytes() const {
    return sizeof(MapSketch) + levels.size() + corners.size() * sizeof(SketchCorner);
  }

  friend bool operator==(const MapSketch&, const MapSketch&) = default;
};

/// Made from the content of a map or from a loaded map. O(cells).
[[nodiscard]] MapSketch sketch_of(std::span<const Feature> features, const OccupancyGrid& grid);
[[nodiscard]] MapSketch sketch_of(const LocalizationMap& map);

}  // namespace cornerfix

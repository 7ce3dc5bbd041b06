/// \file  What the yaml of a map_server map says.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/map_image.hpp>
#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

#include "core/src/map/image_rows.hpp"

namespace cornerfix {

// map_server's own defaults.
inline constexpr double kOccupiedThreshold = 0.65;
inline constexpr double kFreeThreshold = 0.196;

/// The names are map_server's.
struct MapYaml {
  enum class Mode { kTrinary, kScale, kRaw };

  std::string image;
  double resolution = 0.0;
  Pose2 origin;
  bool negate = false;
  double occupied_thresh = kOccupiedThreshold;
  double free_thresh = kFreeThreshold;
  Mode mode = Mode::kTrinary;
  std::vector<std::string> unread_keys;  ///< The first ones of another name.
};

/// `field` of an error is the key, or "yaml". Keys that are not map_server's are passed over.
[[nodiscard]] Result<MapYaml> parse_map_yaml(std::string_view yaml);

/// What a cell is, from how bright its pixel is in [0, 1].
[[nodiscard]] Cell classify(const MapYaml& yaml, double brightness);

/// For an image of this size.
[[nodiscard]] inline Result<ImageRows> empty_rows(const MapYaml& yaml, std::int64_t width,
                                                  std::int64_t height,
                                                  const MapImageLimits& limits) {
  return ImageRows::create(width, height, yaml.resolution, yaml.origin, limits);
}

}  // namespace cornerfix

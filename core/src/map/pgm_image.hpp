/// \file  Grey maps of the Netpbm format, as map_saver writes them.
#pragma once

#include <string_view>

#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

#include "core/src/map/map_yaml.hpp"

namespace cornerfix {

[[nodiscard]] inline bool is_pgm(std::string_view image) {
  return image.starts_with("P2") || image.starts_with("P5");
}

/// P2 and P5 of up to 16 bits. `field` of an error is "image".
[[nodiscard]] Result<OccupancyGrid> parse_pgm(const MapYaml& yaml, std::string_view image,
                                              const MapImageLimits& limits);

}  // namespace cornerfix

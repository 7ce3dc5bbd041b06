/// \file  Maps as png images. The one place of core that knows libpng.
#pragma once

#include <cstddef>
#include <span>

#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

#include "core/src/map/map_yaml.hpp"

namespace cornerfix {

[[nodiscard]] bool is_png(std::span<const std::byte> image);

/// Of any kind of png. `field` of an error is "image".
[[nodiscard]] Result<OccupancyGrid> parse_png(const MapYaml& yaml, std::span<const std::byte> image,
                                              const MapImageLimits& limits);

}  // namespace cornerfix

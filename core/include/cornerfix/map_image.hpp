/// \file  ROS map_server files (a yaml and a pgm or png image) to an occupancy grid and back.
///
/// The image's first row is the highest y, as map_server has it. Reading checks the header against
/// `MapImageLimits` before anything is allocated. Where map_server knows percentages (modes scale
/// and raw), the thresholds decide here too; a pixel that can be seen through is unknown. Nothing
/// here throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

struct MapImageLimits {
  std::int64_t max_cells = 100'000'000;  ///< width * height.
};

/// Reads MAP.yaml and the image it names (relative to the yaml).
[[nodiscard]] Result<OccupancyGrid> read_map_files(const std::filesystem::path& yaml_path,
                                                   const MapImageLimits& limits = {});

/// The same from memory: `image` is a whole pgm (P2, P5) or png file.
[[nodiscard]] Result<OccupancyGrid> parse_map(std::string_view yaml,
                                              std::span<const std::byte> image,
                                              const MapImageLimits& limits = {});

/// An 8-bit grey png in map_server's trinary colours: occupied 0, free 254, unknown 205. Empty for
/// a grid without cells.
[[nodiscard]] std::vector<std::byte> encode_grid_png(const OccupancyGrid& grid);

/// The yaml beside it: image, resolution, origin, negate, thresholds.
[[nodiscard]] std::string encode_grid_yaml(const OccupancyGrid& grid, std::string_view image_name);

}  // namespace cornerfix

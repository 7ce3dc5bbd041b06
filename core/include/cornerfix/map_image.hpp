/// \file  ROS map_server files (a yaml and a pgm, png or bmp image) to an occupancy grid and back.
///
/// The image's first row is the highest y, as map_server has it. Reading checks the header against
/// `MapImageLimits` before anything is allocated. Where map_server knows percentages (modes scale
/// and raw), the thresholds decide here too; a pixel that can be seen through is unknown. An image
/// above the limit whose pixels are finer than 0.05 m is thinned to cells of 0.05 m while it is
/// read. Nothing here throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

struct MapImageLimits {
  std::int64_t max_cells = 100'000'000;  ///< width * height of the grid; of an image 16 times that.
};

/// The two files of a map as they are.
struct MapFiles {
  std::string yaml;
  std::filesystem::path image_path;
  std::string image;
  std::string note;  ///< When the image is not where the yaml says, for people; else empty.
};

/// Loads MAP.yaml and the image it names. The image's path is relative to the yaml, or its name is
/// looked up beside it when the path is of another computer. Of the image only its size is checked.
/// `field` of an error is the path of a file.
[[nodiscard]] Result<MapFiles> load_map_files(const std::filesystem::path& yaml_path,
                                              const MapImageLimits& limits = {});

/// Reads MAP.yaml and the image it names.
[[nodiscard]] Result<OccupancyGrid> read_map_files(const std::filesystem::path& yaml_path,
                                                   const MapImageLimits& limits = {});

/// The same from memory: `image` is a whole pgm (P2, P5), png or bmp file.
[[nodiscard]] Result<OccupancyGrid> parse_map(std::string_view yaml,
                                              std::span<const std::byte> image,
                                              const MapImageLimits& limits = {});

/// A sentence for the map's owner when `grid`, made with this yaml, was thinned.
[[nodiscard]] std::optional<std::string> thinning_note(std::string_view yaml,
                                                       const OccupancyGrid& grid);

/// A sentence for the map's owner when the yaml's thresholds leave most of the border of free space
/// without walls, with the occupied_thresh that fits better if there is one. Nothing when they fit,
/// or when the files cannot be read. As costly as a few parse_map().
[[nodiscard]] std::optional<std::string> threshold_advice(std::string_view yaml,
                                                          std::span<const std::byte> image,
                                                          const MapImageLimits& limits = {});

/// A sentence for the map's owner when a free_thresh above map_server's 0.196 makes cells free that
/// map_saver wrote as unknown: the default of Nav2, 0.25, does. As costly as two parse_map().
[[nodiscard]] std::optional<std::string> unknown_advice(std::string_view yaml,
                                                        std::span<const std::byte> image,
                                                        const MapImageLimits& limits = {});

/// A sentence for the map's owner when the yaml has keys that no map_server reads, as a misspelled
/// occupied_threshold, whose default holds then. Nothing when the yaml cannot be read.
[[nodiscard]] std::optional<std::string> unread_keys(std::string_view yaml);

/// An 8-bit grey png in map_server's trinary colours: occupied 0, free 254, unknown 205. Empty for
/// a grid without cells.
[[nodiscard]] std::vector<std::byte> encode_grid_png(const OccupancyGrid& grid);

/// The yaml beside it: image, resolution, origin, negate, thresholds.
[[nodiscard]] std::string encode_grid_yaml(const OccupancyGrid& grid, std::string_view image_name);

}  // namespace cornerfix

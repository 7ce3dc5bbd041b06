#include <cornerfix/map_image.hpp>

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <new>
#include <optional>
#include <string_view>
#include <utility>

#include "core/src/map/bmp_image.hpp"
#include "core/src/map/map_yaml.hpp"
#include "core/src/map/pgm_image.hpp"
#include "core/src/map/png_map_image.hpp"

namespace cornerfix {

namespace {

constexpr std::uintmax_t kMaxYamlBytes = 1 << 20;

Result<OccupancyGrid> parse_bmp(const MapYaml& yaml, std::span<const std::byte> image,
                                const MapImageLimits& limits) {
  const Result<BmpImage> bmp = BmpImage::open(image);
  if (!bmp) return bmp.error();
  Result<ImageRows> rows = empty_rows(yaml, bmp->width(), bmp->height(), limits);
  if (!rows) return rows.error();
  rows->allocate();
  for (int row = 0; row < rows->height(); ++row) {
    std::int64_t column = 0;
    for (Cell& cell : rows->row(row)) cell = classify(yaml, bmp->brightness(row, column++));
    rows->finish_row(row);
  }
  return std::move(*rows).take();
}

Result<std::string> read_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return Error{ErrorCode::kNotFound, error.message(), path.string()};
  if (size > max_bytes) {
    return Error{
        ErrorCode::kTooLarge,
        std::to_string(size) + " bytes, at most " + std::to_string(max_bytes) + " are taken",
        path.string()};
  }
  std::string text(static_cast<std::size_t>(size), '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file.read(text.data(), static_cast<std::streamsize>(text.size()))) {
    return Error{ErrorCode::kUnavailable, "cannot be read", path.string()};
  }
  return text;
}

/// What an image is that cannot be read here.
std::string other_kind(std::string_view image) {
  struct Kind {
    std::string_view magic;
    const char* name;
  };
  using namespace std::string_view_literals;
  constexpr std::array kKinds = {
      Kind{"P1", "a pbm (P1)"},
      Kind{"P4", "a pbm (P4)"},
      Kind{"P3", "a ppm in colour (P3)"},
      Kind{"P6", "a ppm in colour (P6)"},
      Kind{"P7", "a pam (P7)"},
      Kind{"II*\0"sv, "a tiff"},
      Kind{"MM\0*"sv, "a tiff"},
      Kind{"\xff\xd8\xff", "a jpeg"},
      Kind{"GIF8", "a gif"},
      Kind{"RIFF", "a webp"},
      Kind{"<svg", "an svg"},
      Kind{"<?xml", "an xml or svg"},
      Kind{"\x1f\x8b", "packed with gzip"},
      Kind{"PK\x03\x04", "packed with zip"},
      Kind{"image:", "a yaml"},
      Kind{"version https://git-lfs", "a Git LFS pointer and not the file itself"},
  };
  if (image.empty()) return "empty";
  const auto* const kind = std::ranges::find_if(
      kKinds, [&](const Kind& known) { return image.starts_with(known.magic); });
  return kind == kKinds.end() ? "no image that is known" : kind->name;
}

Result<OccupancyGrid> parse_image(const MapYaml& yaml, std::span<const std::byte> image,
                                  const MapImageLimits& limits) {
  try {
    const std::string_view text(reinterpret_cast<const char*>(image.data()), image.size());
    if (is_pgm(text)) return parse_pgm(yaml, text, limits);
    if (is_png(image)) return parse_png(yaml, image, limits);
    if (BmpImage::is_bmp(image)) return parse_bmp(yaml, image, limits);
    return Error{ErrorCode::kMalformed,
                 "is " + other_kind(text) +
                     ", expected a grey pgm (P2, P5), a png or a bmp: save it as one of these",
                 "image"};
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kTooLarge, "not enough memory", "image"};
  }
}

/// The shortest text that reads back as the same number.
std::string to_text(double value) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

/// How much of the border of free space, but for that of the image, is wall.
double walled_share(const OccupancyGrid& grid) {
  std::size_t walls = 0;
  std::size_t border = 0;
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      if (grid.at({column, row}) != Cell::kFree) continue;
      for (const CellIndex next : {CellIndex{column + 1, row}, CellIndex{column - 1, row},
                                   CellIndex{column, row + 1}, CellIndex{column, row - 1}}) {
        if (!grid.contains(next) || grid.at(next) == Cell::kFree) continue;
        ++border;
        walls += grid.at(next) == Cell::kOccupied ? 1 : 0;
      }
    }
  }
  return border == 0 ? 1.0 : static_cast<double>(walls) / static_cast<double>(border);
}

struct ImagePath {
  std::filesystem::path path;
  std::string note;
};

/// Where the image of a yaml is. Its path may be one of another computer, or the pair was renamed.
/// Then it is the file beside the yaml of the image's name, or of the yaml's.
ImagePath image_beside(const std::filesystem::path& yaml_path, const std::string& image) {
  const std::filesystem::path directory = yaml_path.parent_path();
  std::error_code error;
  std::filesystem::path named = directory / image;
  if (std::filesystem::exists(named, error)) return {std::move(named), ""};
  std::string with_slashes = image;
  std::ranges::replace(with_slashes, '\\', '/');
  std::filesystem::path of_windows = directory / with_slashes;
  if (std::filesystem::exists(of_windows, error)) return {std::move(of_windows), ""};
  const std::filesystem::path name = image.substr(image.find_last_of("/\\") + 1);
  const std::filesystem::path renamed = yaml_path.stem().string() + name.extension().string();
  for (const std::filesystem::path& candidate : {name, renamed}) {
    std::filesystem::path beside = directory / candidate;
    if (beside == yaml_path || !std::filesystem::is_regular_file(beside, error)) continue;
    std::string note = "image: " + image + " is not there, " + beside.string() + " is read instead";
    return {std::move(beside), std::move(note)};
  }
  return {std::move(named), ""};
}

std::string percent(double share) { return std::to_string(std::lround(100.0 * share)) + " %"; }

}  // namespace

Result<MapFiles> load_map_files(const std::filesystem::path& yaml_path,
                                const MapImageLimits& limits) {
  Result<std::string> text = read_file(yaml_path, kMaxYamlBytes);
  if (!text) return text.error();
  const Result<MapYaml> yaml = parse_map_yaml(*text);
  if (!yaml) {
    return Error{yaml.error().code, yaml.error().field + ": " + yaml.error().message,
                 yaml_path.string()};
  }
  auto [image_path, note] = image_beside(yaml_path, yaml->image);
  std::error_code error;
  if (!std::filesystem::exists(image_path, error)) {
    return Error{
        ErrorCode::kNotFound,
        "no such file, nor one of that name beside the yaml, whose image is " + yaml->image,
        image_path.string()};
  }
  // A plain pgm takes at most six bytes a pixel, beside its header.
  const auto max_bytes = static_cast<std::uintmax_t>(limits.max_cells) * 6 + kMaxYamlBytes;
  Result<std::string> image = read_file(image_path, max_bytes);
  if (!image) return image.error();
  return MapFiles{std::move(*text), std::move(image_path), std::move(*image), std::move(note)};
}

Result<OccupancyGrid> read_map_files(const std::filesystem::path& yaml_path,
                                     const MapImageLimits& limits) {
  const Result<MapFiles> files = load_map_files(yaml_path, limits);
  if (!files) return files.error();
  Result<OccupancyGrid> grid =
      parse_map(files->yaml, std::as_bytes(std::span(files->image)), limits);
  if (!grid) return Error{grid.error().code, grid.error().message, files->image_path.string()};
  return grid;
}

Result<OccupancyGrid> parse_map(std::string_view yaml, std::span<const std::byte> image,
                                const MapImageLimits& limits) {
  const Result<MapYaml> parsed = parse_map_yaml(yaml);
  if (!parsed) return parsed.error();
  return parse_image(*parsed, image, limits);
}

std::optional<std::string> thinning_note(std::string_view yaml, const OccupancyGrid& grid) {
  const Result<MapYaml> parsed = parse_map_yaml(yaml);
  if (!parsed || parsed->resolution == grid.resolution) return std::nullopt;
  return "the image is too large at " + to_text(parsed->resolution) +
         " m per pixel: it was thinned to " + to_text(grid.resolution) + " m per cell";
}

std::optional<std::string> threshold_advice(std::string_view yaml, std::span<const std::byte> image,
                                            const MapImageLimits& limits) {
  constexpr double kFewWalls = 0.2;
  constexpr double kEnoughWalls = 0.5;
  const Result<MapYaml> parsed = parse_map_yaml(yaml);
  if (!parsed) return std::nullopt;
  const Result<OccupancyGrid> grid = parse_image(*parsed, image, limits);
  if (!grid) return std::nullopt;
  const double walled = walled_share(*grid);
  if (walled >= kFewWalls) return std::nullopt;
  std::string advice = "at occupied_thresh " + to_text(parsed->occupied_thresh) + " only " +
                       percent(walled) + " of the border of free space is wall";
  for (const double threshold : {0.5, 0.4, 0.3, 0.2}) {
    MapYaml other = *parsed;
    if (threshold >= other.occupied_thresh) continue;
    other.occupied_thresh = threshold;
    other.free_thresh = std::min(other.free_thresh, threshold);
    const Result<OccupancyGrid> fitting = parse_image(other, image, limits);
    if (!fitting || walled_share(*fitting) < kEnoughWalls) continue;
    return advice + "; occupied_thresh " + to_text(threshold) + " would make it " +
           percent(walled_share(*fitting));
  }
  return advice;
}

std::optional<std::string> unknown_advice(std::string_view yaml, std::span<const std::byte> image,
                                          const MapImageLimits& limits) {
  constexpr double kFewCells = 0.02;
  const Result<MapYaml> parsed = parse_map_yaml(yaml);
  if (!parsed || parsed->free_thresh <= kFreeThreshold || parsed->mode == MapYaml::Mode::kRaw) {
    return std::nullopt;
  }
  MapYaml usual = *parsed;
  usual.free_thresh = kFreeThreshold;
  const Result<OccupancyGrid> grid = parse_image(*parsed, image, limits);
  const Result<OccupancyGrid> fitting = parse_image(usual, image, limits);
  if (!grid || !fitting) return std::nullopt;
  const auto free_cells = [](const OccupancyGrid& cells) {
    return static_cast<double>(std::ranges::count(cells.cells, Cell::kFree));
  };
  const double share = (free_cells(*grid) - free_cells(*fitting)) /
                       static_cast<double>(std::max<std::size_t>(grid->cells.size(), 1));
  if (share < kFewCells) return std::nullopt;
  return "at free_thresh " + to_text(parsed->free_thresh) + " " + percent(share) +
         " of the cells are free that free_thresh " + to_text(kFreeThreshold) +
         " leaves unknown; map_saver writes unknown cells in such a grey (205)";
}

std::optional<std::string> unread_keys(std::string_view yaml) {
  const Result<MapYaml> parsed = parse_map_yaml(yaml);
  if (!parsed || parsed->unread_keys.empty()) return std::nullopt;
  std::string names;
  for (const std::string& key : parsed->unread_keys) names += (names.empty() ? "" : ", ") + key;
  return "keys that are not read: " + names +
         "; read are image, resolution, origin, negate, occupied_thresh, free_thresh and mode";
}

std::string encode_grid_yaml(const OccupancyGrid& grid, std::string_view image_name) {
  const Pose2& origin = grid.T_map_grid;
  return "image: " + YAML::Dump(YAML::Node(std::string(image_name))) +
         "\nresolution: " + to_text(grid.resolution) + "\norigin: [" + to_text(origin.x) + ", " +
         to_text(origin.y) + ", " + to_text(origin.yaw) +
         "]\nnegate: 0\noccupied_thresh: " + to_text(kOccupiedThreshold) +
         "\nfree_thresh: " + to_text(kFreeThreshold) + "\nmode: trinary\n";
}

}  // namespace cornerfix

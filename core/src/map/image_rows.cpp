#include "core/src/map/image_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

namespace cornerfix {

namespace {

/// How many times as many pixels as cells are read at most.
constexpr std::int64_t kMaxThinning = 16;

/// The cell of the thinned grid that holds the middle of a pixel.
int thinned(int pixel, double resolution) {
  return static_cast<int>(std::floor((pixel + 0.5) * resolution / kThinnedResolution));
}

std::string metres_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

Error too_large(std::int64_t width, std::int64_t height, double resolution,
                const MapImageLimits& limits) {
  constexpr double kCentimetre = 0.01;
  const double cells = static_cast<double>(width) * static_cast<double>(height);
  const double fitting =
      resolution * std::sqrt(cells / static_cast<double>(limits.max_cells)) / kCentimetre;
  return {ErrorCode::kTooLarge,
          std::to_string(width) + " x " + std::to_string(height) + " pixels of " +
              metres_text(resolution) + " m, at most " + std::to_string(limits.max_cells) +
              " are taken: save the map with a resolution of " +
              metres_text(std::ceil(fitting) * kCentimetre) + " m or coarser, or cut it",
          "image"};
}

}  // namespace

Result<ImageRows> ImageRows::create(std::int64_t width, std::int64_t height, double resolution,
                                    const Pose2& T_map_grid, const MapImageLimits& limits) {
  if (width < 1 || height < 1) {
    return Error{ErrorCode::kMalformed, "an image without pixels", "image"};
  }
  constexpr std::int64_t kMaxSide = std::numeric_limits<int>::max();
  if (width > kMaxSide || height > kMaxSide || width > limits.max_cells * kMaxThinning / height) {
    return too_large(width, height, resolution, limits);
  }
  ImageRows rows;
  rows.width_ = static_cast<int>(width);
  rows.height_ = static_cast<int>(height);
  rows.resolution_ = resolution;
  rows.grid_.resolution = resolution;
  rows.grid_.T_map_grid = T_map_grid;
  rows.grid_.width = rows.width_;
  rows.grid_.height = rows.height_;
  if (width <= limits.max_cells / height) return rows;
  if (resolution >= kThinnedResolution) return too_large(width, height, resolution, limits);
  rows.grid_.resolution = kThinnedResolution;
  rows.grid_.width = thinned(rows.width_ - 1, resolution) + 1;
  rows.grid_.height = thinned(rows.height_ - 1, resolution) + 1;
  if (rows.grid_.width > limits.max_cells / rows.grid_.height) {
    return too_large(width, height, resolution, limits);
  }
  return rows;
}

void ImageRows::allocate() {
  grid_.cells.assign(static_cast<std::size_t>(grid_.width) * static_cast<std::size_t>(grid_.height),
                     Cell::kUnknown);
  if (!is_thinned()) return;
  pixels_.resize(static_cast<std::size_t>(width_));
  for (int pixel = 0; pixel < width_; ++pixel) columns_.push_back(thinned(pixel, resolution_));
}

std::span<Cell> ImageRows::row(int image_row) {
  if (is_thinned()) return pixels_;
  return std::span(grid_.cells)
      .subspan(grid_.offset({0, height_ - 1 - image_row}), static_cast<std::size_t>(width_));
}

void ImageRows::finish_row(int image_row) {
  if (!is_thinned()) return;
  Cell* const cells =
      grid_.cells.data() + grid_.offset({0, thinned(height_ - 1 - image_row, resolution_)});
  for (std::size_t pixel = 0; pixel < pixels_.size(); ++pixel) {
    Cell& cell = cells[columns_[pixel]];
    if (pixels_[pixel] == Cell::kOccupied || cell == Cell::kUnknown) cell = pixels_[pixel];
  }
}

}  // namespace cornerfix

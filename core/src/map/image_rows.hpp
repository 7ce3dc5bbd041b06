/// \file  An occupancy grid that is filled row by row from an image, and thinned on the way when
/// the image is too large.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/map_image.hpp>
#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

/// Pixels finer than this are joined to cells of this size when the image is above the limit.
inline constexpr double kThinnedResolution = 0.05;  // [m]

class ImageRows {
 public:
  /// Allocates nothing yet. An image that is too large even when thinned is an error that says at
  /// which resolution it fits.
  [[nodiscard]] static Result<ImageRows> create(std::int64_t width, std::int64_t height,
                                                double resolution, const Pose2& T_map_grid,
                                                const MapImageLimits& limits);

  [[nodiscard]] int width() const { return width_; }    ///< Of the image.
  [[nodiscard]] int height() const { return height_; }  ///< Of the image.
  [[nodiscard]] bool is_thinned() const { return grid_.resolution != resolution_; }

  void allocate();
  /// The pixels of a row, to be filled; row 0 is the uppermost. Until the next call.
  [[nodiscard]] std::span<Cell> row(int image_row);
  /// Takes what row() was filled with. A thinned cell is occupied if any of its pixels is, or else
  /// free if any is.
  void finish_row(int image_row);

  [[nodiscard]] OccupancyGrid take() && { return std::move(grid_); }

 private:
  int width_ = 0;
  int height_ = 0;
  double resolution_ = 0.0;  ///< Of the image [m].
  OccupancyGrid grid_;
  std::vector<Cell> pixels_;  ///< Of a row, when thinned.
  std::vector<int> columns_;  ///< Of the grid, per pixel of a row, when thinned.
};

}  // namespace cornerfix

/// \file  A distance field that has memory only where walls are: of a local map, which most robots
/// see a small part of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

#include "core/src/map/distance_field.hpp"

namespace cornerfix {

/// The same distances as those of a DistanceField that was stamped with the same points, to the
/// last bit. Cells are held in square tiles, and a tile no point was stamped near is not held. A
/// tile repeats the first column and row of its neighbours, so that one tile has all four cells
/// about a point. Value type. Reading is thread safe; `stamp` is not.
class TiledField {
 public:
  TiledField() = default;
  /// width x height cells at DistanceField::kMaxDistance; frames as of a DistanceField.
  TiledField(const Pose2& T_frame_grid, double resolution, int width, int height);

  /// Lowers the cells about points of frame `grid` to their distance from them, within `radius_m`.
  /// O(points * (radius / resolution)^2 + cells / 256).
  void stamp(std::span<const Point2> points_grid, double radius_m);
  /// All cells at kMaxDistance again, elsewhere. Keeps its memory.
  void clear(const Pose2& T_frame_grid);

  /// Bilinear between cell centres; kMaxDistance outside.
  [[nodiscard]] double distance(const Point2& point_grid) const {
    return interpolated_distance(*this, point_grid);
  }
  /// At the nearest cell centre; kMaxDistance outside.
  [[nodiscard]] double nearest(const Point2& point_grid) const {
    const double x = point_grid.x() * inverse_resolution_;
    const double y = point_grid.y() * inverse_resolution_;
    if (!(x >= 0.0 && y >= 0.0 && x < width_ && y < height_)) return DistanceField::kMaxDistance;
    return DistanceField::kStep *
           static_cast<double>(*square(static_cast<int>(x), static_cast<int>(y)).lower);
  }
  /// Column in [0, width), row in [0, height).
  [[nodiscard]] FieldSquare square(int column, int row) const {
    const auto u = static_cast<std::size_t>(column);  // Unsigned: divided by shifts.
    const auto v = static_cast<std::size_t>(row);
    const std::size_t number =
        numbers_[v / kTile * static_cast<std::size_t>(tiles_per_row_) + u / kTile];
    const std::uint8_t* lower = &cells_[number * kTileCells + v % kTile * kStride + u % kTile];
    return {lower, lower + kStride};
  }

  [[nodiscard]] const Pose2& T_grid_frame() const { return T_grid_frame_; }
  [[nodiscard]] double resolution() const { return resolution_; }
  [[nodiscard]] double cells_per_metre() const { return inverse_resolution_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// Of the heap.
  [[nodiscard]] std::size_t bytes() const {
    return cells_.capacity() + numbers_.capacity() * sizeof(std::uint16_t);
  }

 private:
  static constexpr int kTile = 16;  ///< Cells to a side, without those of the neighbours.
  static constexpr int kStride = kTile + 1;
  static constexpr std::size_t kTileCells = static_cast<std::size_t>(kStride) * kStride;

  [[nodiscard]] std::size_t tile_of(int tile_column, int tile_row) const {
    return static_cast<std::size_t>(tile_row) * static_cast<std::size_t>(tiles_per_row_) +
           static_cast<std::size_t>(tile_column);
  }
  /// The cells of a tile, allocated if need be.
  [[nodiscard]] std::uint8_t* tile(int tile_column, int tile_row);
  void lower(const class StampPatch& patch);

  Pose2 T_grid_frame_;
  double resolution_ = 0.0;
  double inverse_resolution_ = 0.0;
  int width_ = 0;
  int height_ = 0;
  int tiles_per_row_ = 0;
  std::vector<std::uint16_t> numbers_;  ///< Of tiles, by place; 0 for one that is not held.
  std::vector<std::uint8_t> cells_;     ///< Tile by tile, in units of kStep; tile 0 is far.
};

}  // namespace cornerfix

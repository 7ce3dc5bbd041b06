#include "core/src/map/tiled_field.hpp"

#include <algorithm>
#include <cassert>

#include "core/src/map/stamp_patch.hpp"

namespace cornerfix {
namespace {

/// Whether some rows of a patch have no distance in the cells that one tile holds from `column` on.
bool has_no_distance(const StampPatch& patch, int column, int cells, int first_row, int last_row) {
  for (int row = first_row; row <= last_row; ++row) {
    const std::uint8_t* const begin = patch.cells(column, row);
    if (std::any_of(begin, begin + cells, [](std::uint8_t cell) { return cell != 255; }))
      return false;
  }
  return true;
}

}  // namespace

TiledField::TiledField(const Pose2& T_frame_grid, double resolution, int width, int height)
    : T_grid_frame_(inverse(T_frame_grid)),
      resolution_(resolution),
      inverse_resolution_(1.0 / resolution),
      width_(width),
      height_(height),
      tiles_per_row_((width + kTile - 1) / kTile),
      numbers_(static_cast<std::size_t>(tiles_per_row_) *
               static_cast<std::size_t>((height + kTile - 1) / kTile)),
      cells_(kTileCells, 255) {
  static_assert(kTile <= StampPatch::kPadding);
  assert(numbers_.size() < 65'535 && "tile numbers fit 16 bits");
}

void TiledField::clear(const Pose2& T_frame_grid) {
  T_grid_frame_ = inverse(T_frame_grid);
  std::ranges::fill(numbers_, std::uint16_t{0});
  cells_.resize(kTileCells);
}

void TiledField::stamp(std::span<const Point2> points_grid, double radius_m) {
  for_each_patch(*this, points_grid, radius_m, [this](const StampPatch& patch) { lower(patch); });
}

/// Each tile that has cells of the patch, be it in the column or row that it repeats.
void TiledField::lower(const StampPatch& patch) {
  const int left = std::max(0, patch.first_column() - 1) / kTile;
  const int bottom = std::max(0, patch.first_row() - 1) / kTile;
  for (int tile_row = bottom; tile_row <= patch.last_row() / kTile; ++tile_row) {
    const int first_row = std::max(patch.first_row(), tile_row * kTile);
    const int last_row = std::min(patch.last_row(), tile_row * kTile + kTile);
    for (int tile_column = left; tile_column <= patch.last_column() / kTile; ++tile_column) {
      const bool is_held = numbers_[tile_of(tile_column, tile_row)] != 0;
      if (!is_held && has_no_distance(patch, tile_column * kTile, kStride, first_row, last_row))
        continue;
      std::uint8_t* cells = tile(tile_column, tile_row);
      for (int row = first_row; row <= last_row; ++row) {
        const std::uint8_t* lowered = patch.cells(tile_column * kTile, row);
        std::uint8_t* to = cells + (row - tile_row * kTile) * kStride;
        for (int i = 0; i < kStride; ++i) to[i] = std::min(to[i], lowered[i]);
      }
    }
  }
}

std::uint8_t* TiledField::tile(int tile_column, int tile_row) {
  constexpr std::size_t kLeastGrowth = 16 * kTileCells;
  std::uint16_t& number = numbers_[tile_of(tile_column, tile_row)];
  if (number == 0) {
    number = static_cast<std::uint16_t>(cells_.size() / kTileCells);
    // By less than twice, since most of it is held for long.
    if (cells_.size() + kTileCells > cells_.capacity())
      cells_.reserve(cells_.size() + std::max(kLeastGrowth, cells_.size() / 4));
    cells_.resize(cells_.size() + kTileCells, 255);
  }
  return &cells_[number * kTileCells];
}

}  // namespace cornerfix

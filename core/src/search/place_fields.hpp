/// \file  A map as the search for poses reads it: weights of hits and of the robot's path. They are
/// small whole numbers in 0.2 m cells, with a border as wide as points may reach.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

#include "core/src/map/evidence_model.hpp"

namespace cornerfix {

inline constexpr int kBorder = 160;  ///< Cells that points may reach beyond the map proper.
inline constexpr int kBlock = 2;     ///< Cells along a block of poses.

// Weights are quantised so coarsely that eight of them can be summed in a byte.
inline constexpr double kLowestWeight = -1.25;  ///< [nat], quantised as 0.
inline constexpr double kStepsPerNat = 18.5;    ///< The best weight, 0.41, is 31.
inline constexpr int kHighestValue = 31;
inline constexpr std::uint8_t kWayFree = 18;
inline constexpr std::uint8_t kWayUnknown = 12;
inline constexpr std::uint8_t kWayBlocked = 0;

struct CellOffset {
  std::int32_t x = 0;
  std::int32_t y = 0;
};

/// Values of cells, and their maxima over blocks.
class BlockField {
 public:
  BlockField() = default;
  /// \param cells    height rows of width; both are multiples of a block.
  /// \param outside  Value beyond them.
  BlockField(std::span<const std::uint8_t> cells, int width, int height, std::uint8_t outside);

  [[nodiscard]] std::uint8_t cell(std::ptrdiff_t x, std::ptrdiff_t y) const {
    return static_cast<std::uint8_t>(quads_[static_cast<std::size_t>(y * width_ + x)] & 0xFFU);
  }
  /// By cell, the values of the four cells of the block that begins there, each a byte of a word.
  [[nodiscard]] const std::uint32_t* quads() const { return quads_.data(); }

  /// The maximum over the block that begins at a cell; those of the blocks beside it follow, and
  /// those of the next row of blocks come `blocks_a_row` later.
  [[nodiscard]] const std::uint8_t* maxima_from(std::ptrdiff_t x, std::ptrdiff_t y) const;
  [[nodiscard]] std::size_t blocks_a_row() const {
    return static_cast<std::size_t>(width_ / kBlock);
  }
  [[nodiscard]] std::size_t bytes() const {
    return quads_.size() * sizeof(quads_[0]) + maxima_.size();
  }

 private:
  std::ptrdiff_t width_ = 0;
  std::ptrdiff_t height_ = 0;
  std::vector<std::uint32_t> quads_;
  std::vector<std::uint8_t> maxima_;  ///< By where in a block a block begins, then row by row.
};

struct PlaceFields {
  explicit PlaceFields(const ClassField& classes);

  Pose2 T_map_grid;
  double cell_m = 0.0;
  int inner_width = 0;  ///< Cells of the map proper.
  int inner_height = 0;
  int width = 0;  ///< With the border; a multiple of a block.
  int height = 0;
  BlockField ends;
  BlockField way;
  std::vector<std::uint8_t> nothing;  ///< A value of 0 for every block.
};

}  // namespace cornerfix

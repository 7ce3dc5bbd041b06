/// \file  Blocks: the pieces of evidence that change independently of each other.
///
/// What stands in a building changes object by object: a pallet, a car, a door. A block is what one
/// connected object covers of one square, so long walls are several blocks. Objects as small as
/// noise and the passed points form one more block per square (docs/method/03-local-map.md,
/// section 3.3).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cornerfix {

/// Side of the squares [m]. A wall, car or pallet inside of one square changes as a whole.
inline constexpr double kBlockSize = 2.0;

struct HitCell {
  int column = 0;
  int row = 0;
  std::uint16_t square = 0;  ///< In [0, square_count).
};

struct HitBlocks {
  std::vector<std::uint16_t> of_hit;
  std::size_t count = 0;  ///< Of all blocks, the squares among them.
};

/// \param cells  One per hit, each once.
/// \return The block of each hit. Blocks below `square_count` are the squares; a connected object
/// of three cells or more has a number of its own from there. Cells are connected across sides and
/// corners. O(hits + cells of the box about them).
[[nodiscard]] HitBlocks blocks_of_hits(std::span<const HitCell> cells, std::size_t square_count);

/// (sum n)^2 / sum n^2 of the numbers n of hits per square: how many equal squares would be as
/// many.
[[nodiscard]] double effective_squares(std::span<const HitCell> cells, std::size_t square_count);

}  // namespace cornerfix

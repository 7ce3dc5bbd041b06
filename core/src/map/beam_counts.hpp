/// \file  What beams told of a cell, and how a later drive outweighs an earlier one.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>

namespace cornerfix {

/// How many beams ended in a cell and how many passed it, saturating.
struct BeamCounts {
  std::uint16_t hits = 0;
  std::uint16_t passes = 0;
};

inline void count(std::uint16_t& counter) {
  if (counter < std::numeric_limits<std::uint16_t>::max()) ++counter;
}

/// Adds the counts of a later drive to those of earlier ones, cell by cell of `grid`.
///
/// Where the later drive looked, what was counted before keeps its proportions but weighs at most
/// five beams or a tenth of the later ones: so a wall is gone when twenty beams passed where it
/// was, however long it stood there, and a new one is there when two ended on it. "Looked" is told
/// by a cell and its eight neighbours, since beams end at a wall's face. Elsewhere nothing changes.
/// O(cells).
void outweigh(std::vector<BeamCounts>& earlier, std::span<const BeamCounts> later,
              const OccupancyGrid& grid);

}  // namespace cornerfix

/// \file  Counts of hits and misses of a cell, and how a later run outweighs an earlier one.
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

/// Adds the counts of a later run to those of earlier ones, cell by cell of `grid`.
///
/// Where the later run looked, what was counted before keeps its proportions but weighs at most
/// five beams or a tenth of the later ones. So a wall is gone when twenty beams passed where it
/// was, however long it stood there. A new one is there when two beams hit it. A run looked at a
/// cell when its beams came to the cell or its eight neighbours, since beams end at a wall's face.
/// Elsewhere nothing changes. O(cells).
void outweigh(std::vector<BeamCounts>& earlier, std::span<const BeamCounts> later,
              const OccupancyGrid& grid);

}  // namespace cornerfix

#include "core/src/map/beam_counts.hpp"

#include <algorithm>
#include <cmath>

namespace cornerfix {

namespace {

constexpr double kEarlierBeams = 5.0;   // what earlier drives may weigh against few beams,
constexpr double kEarlierShare = 0.10;  // and as a share of many: below the least share of a wall

double beams(const BeamCounts& counts) {
  return static_cast<double>(counts.hits) + static_cast<double>(counts.passes);
}

/// The most beams that came to a cell or one of its neighbours.
double most_beams_about(std::span<const BeamCounts> counts, const OccupancyGrid& grid,
                        CellIndex cell) {
  double most = 0.0;
  for (int row = std::max(0, cell.row - 1); row <= std::min(grid.height - 1, cell.row + 1); ++row) {
    for (int column = std::max(0, cell.column - 1);
         column <= std::min(grid.width - 1, cell.column + 1); ++column) {
      most = std::max(most, beams(counts[grid.offset({column, row})]));
    }
  }
  return most;
}

void scale(std::uint16_t& counter, double factor) {
  counter = static_cast<std::uint16_t>(std::lround(static_cast<double>(counter) * factor));
}

void limit(BeamCounts& counts, double most) {
  if (beams(counts) <= most) return;
  const double factor = most / beams(counts);
  scale(counts.hits, factor);
  scale(counts.passes, factor);
}

void add(std::uint16_t& counter, std::uint16_t more) {
  constexpr std::uint16_t kMost = std::numeric_limits<std::uint16_t>::max();
  counter = more > kMost - counter ? kMost : static_cast<std::uint16_t>(counter + more);
}

}  // namespace

void outweigh(std::vector<BeamCounts>& earlier, std::span<const BeamCounts> later,
              const OccupancyGrid& grid) {
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      BeamCounts& counts = earlier[grid.offset({column, row})];
      const BeamCounts& more = later[grid.offset({column, row})];
      const double looks = most_beams_about(later, grid, {column, row});
      if (looks > 0.0) limit(counts, std::max(kEarlierBeams, kEarlierShare * looks));
      add(counts.hits, more.hits);
      add(counts.passes, more.passes);
    }
  }
}

}  // namespace cornerfix

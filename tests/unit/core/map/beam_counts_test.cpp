#include "core/src/map/beam_counts.hpp"

#include <gtest/gtest.h>

namespace cornerfix {
namespace {

/// Nine cells in a row.
OccupancyGrid strip() {
  OccupancyGrid grid;
  grid.width = 9;
  grid.height = 1;
  grid.cells.assign(9, Cell::kUnknown);
  return grid;
}

constexpr std::uint16_t kFull = std::numeric_limits<std::uint16_t>::max();

double hit_share(const BeamCounts& counts) {
  return static_cast<double>(counts.hits) / (counts.hits + counts.passes);
}

TEST(BeamCounts, StopAtTheirLimit) {
  std::uint16_t counter = kFull - 1;
  count(counter);
  EXPECT_EQ(counter, kFull);
  count(counter);
  EXPECT_EQ(counter, kFull);
}

TEST(BeamCounts, OfAnOldWallWeighLittleOnceBeamsPassIt) {
  std::vector<BeamCounts> counts(9);
  counts[4] = {.hits = 10'000, .passes = 0};
  std::vector<BeamCounts> later(9);
  later[4] = {.hits = 0, .passes = 20};
  outweigh(counts, later, strip());
  EXPECT_LE(hit_share(counts[4]), 0.2);
}

TEST(BeamCounts, OfOldFreeSpaceWeighLittleOnceTwoBeamsEndThere) {
  std::vector<BeamCounts> counts(9);
  counts[4] = {.hits = 0, .passes = 10'000};
  std::vector<BeamCounts> later(9);
  later[4] = {.hits = 2, .passes = 0};
  outweigh(counts, later, strip());
  EXPECT_GE(hit_share(counts[4]), 0.2);
}

TEST(BeamCounts, StayWhereTheLaterRunDidNotLook) {
  std::vector<BeamCounts> counts(9);
  counts[0] = {.hits = 300, .passes = 40};
  std::vector<BeamCounts> later(9);
  later[4] = {.hits = 0, .passes = 20};
  outweigh(counts, later, strip());
  EXPECT_EQ(counts[0].hits, 300);
  EXPECT_EQ(counts[0].passes, 40);
}

TEST(BeamCounts, OfNeighboursOfASeenCellWeighLittleToo) {
  std::vector<BeamCounts> counts(9);
  counts[5] = {.hits = 300, .passes = 0};
  std::vector<BeamCounts> later(9);
  later[4] = {.hits = 0, .passes = 20};
  outweigh(counts, later, strip());
  EXPECT_EQ(counts[5].hits, 5);
}

TEST(BeamCounts, AddUpWithoutOverflow) {
  std::vector<BeamCounts> counts(9);
  std::vector<BeamCounts> later(9);
  later[4] = {.hits = kFull, .passes = 0};
  outweigh(counts, later, strip());
  outweigh(counts, later, strip());
  EXPECT_EQ(counts[4].hits, kFull);
}

}  // namespace
}  // namespace cornerfix

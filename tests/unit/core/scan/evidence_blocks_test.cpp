#include "core/src/scan/evidence_blocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

namespace cornerfix {
namespace {

constexpr int kCellsPerSquare = 10;

/// Squares are numbered along rows of ten.
HitCell hit(int column, int row) {
  const int square = row / kCellsPerSquare * 10 + column / kCellsPerSquare;
  return {column, row, static_cast<std::uint16_t>(square)};
}

std::set<std::uint16_t> distinct(const HitBlocks& blocks) {
  return {blocks.of_hit.begin(), blocks.of_hit.end()};
}

TEST(EvidenceBlocks, TwoObjectsInOneSquareAreTwoBlocks) {
  const HitBlocks blocks = blocks_of_hits(
      std::vector{hit(1, 1), hit(2, 1), hit(3, 2), hit(7, 7), hit(7, 8), hit(8, 8)}, 100);
  EXPECT_EQ(blocks.count, 102U);
  EXPECT_EQ(blocks.of_hit, (std::vector<std::uint16_t>{100, 100, 100, 101, 101, 101}));
}

TEST(EvidenceBlocks, AWallIsOneBlockPerSquare) {
  std::vector<HitCell> wall;
  for (int column = 0; column < 30; ++column) wall.push_back(hit(column, 4));
  EXPECT_EQ(distinct(blocks_of_hits(wall, 100)).size(), 3U);
}

TEST(EvidenceBlocks, PiecesBelowThreeCellsStayWithTheirSquare) {
  const HitBlocks blocks =
      blocks_of_hits(std::vector{hit(1, 1), hit(2, 2), hit(5, 5), hit(9, 1), hit(11, 1)}, 100);
  EXPECT_EQ(blocks.count, 100U);
  EXPECT_EQ(blocks.of_hit, (std::vector<std::uint16_t>{0, 0, 0, 0, 1}));
}

TEST(EvidenceBlocks, DoNotDependOnTheOrderOfTheHits) {
  std::vector<HitCell> cells{hit(1, 1), hit(2, 1), hit(3, 2), hit(7, 7), hit(7, 8), hit(8, 8)};
  const std::size_t count = distinct(blocks_of_hits(cells, 100)).size();
  std::ranges::reverse(cells);
  EXPECT_EQ(distinct(blocks_of_hits(cells, 100)).size(), count);
}

TEST(EvidenceBlocks, NoHitsFormNoBlock) {
  EXPECT_TRUE(blocks_of_hits({}, 7).of_hit.empty());
  EXPECT_EQ(blocks_of_hits({}, 7).count, 7U);
  EXPECT_EQ(effective_squares({}, 7), 0.0);
}

TEST(EvidenceBlocks, EqualSquaresCountOneEach) {
  EXPECT_NEAR(effective_squares(std::vector{hit(0, 0), hit(1, 0), hit(10, 0), hit(11, 0)}, 100),
              2.0, 1e-9);
  EXPECT_NEAR(effective_squares(std::vector{hit(0, 0), hit(1, 0), hit(2, 0), hit(10, 0)}, 100),
              16.0 / 10.0, 1e-9);
}

}  // namespace
}  // namespace cornerfix

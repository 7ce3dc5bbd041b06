#include "bench/rivals/probability_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/scan_simulator.hpp"

namespace cornerfix::bench {
namespace {

using cornerfix::testing::SceneBuilder;

std::vector<PosedScan> scans_of_a_room(std::size_t count) {
  const SceneBuilder room = SceneBuilder().room({0, 0}, {4, 3});
  const Pose2 pose{1.5, 1.5, 0.4};
  const PosedScan scan{cornerfix::testing::simulate_scan(room, {.beams = 720}, pose), {}, pose};
  return std::vector<PosedScan>(count, scan);
}

double probability_at(const ProbabilityGrid& grid, const Point2& point) {
  const Point2 cell = (point - grid.origin_map) / grid.resolution;
  const auto index = static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(grid.width) +
                     static_cast<std::size_t>(cell.x());
  return ProbabilityGrid::probability(grid.values.at(index));
}

TEST(ProbabilityGrid, IsEmptyWithoutScans) {
  EXPECT_TRUE(build_probability_grid({}, {}).values.empty());
}

TEST(ProbabilityGrid, GivesAWallSeenOnceTheHitProbability) {
  const ProbabilityGrid grid = build_probability_grid(scans_of_a_room(1), {});
  EXPECT_NEAR(probability_at(grid, {4.0, 1.52}), 0.55, 0.005);
}

TEST(ProbabilityGrid, BelievesAWallSeenOften) {
  const ProbabilityGrid grid = build_probability_grid(scans_of_a_room(40), {});
  EXPECT_NEAR(probability_at(grid, {4.0, 1.52}), ProbabilityGrid::kMax, 0.005);
}

TEST(ProbabilityGrid, LowersWhatBeamsPass) {
  const ProbabilityGrid grid = build_probability_grid(scans_of_a_room(40), {});
  EXPECT_LT(probability_at(grid, {2.5, 1.5}), 0.35);
}

TEST(ProbabilityGrid, GivesUnknownCellsTheLowestProbability) {
  const ProbabilityGrid grid = build_probability_grid(scans_of_a_room(1), {});
  EXPECT_DOUBLE_EQ(ProbabilityGrid::probability(grid.values.front()), ProbabilityGrid::kMin);
}

}  // namespace
}  // namespace cornerfix::bench

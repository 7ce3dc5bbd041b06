#include "bench/rivals/branch_and_bound.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "support/matchers.hpp"
#include "tests/unit/bench/mapped_offices.hpp"

namespace cornerfix::bench {
namespace {

const ProbabilityGrid& office_grid() {
  static const ProbabilityGrid grid = build_probability_grid(testing::office_scans(), {});
  return grid;
}

const BranchAndBoundMatcher& office_matcher() {
  static const BranchAndBoundMatcher matcher(office_grid(), 7);
  return matcher;
}

/// The best score by trying all poses of a small window, one by one.
double best_score_by_trying(const ProbabilityGrid& grid, const std::vector<Point2>& points,
                            const SearchWindow& window) {
  const BranchAndBoundMatcher flat(grid, 1);  // without a pyramid nothing is bounded
  return flat.match(points, window, 0.0)->score;
}

TEST(BranchAndBoundMatcher, FindsTheRobotAnywhereInTheMap) {
  for (const Pose2& truth : {Pose2{2.0, 4.0, 0.3}, Pose2{7.0, 4.0, -2.0}, Pose2{13.0, 3.5, 3.0}}) {
    const auto match = office_matcher().match(testing::ends_seen(truth), {}, 0.3);
    ASSERT_TRUE(match) << truth.x << ", " << truth.y;
    EXPECT_THAT(match->T_map_base_link, cornerfix::testing::IsPoseNear(truth, 0.1, 0.03));
  }
}

TEST(BranchAndBoundMatcher, FindsThePoseThatTryingAllFinds) {
  const Pose2 truth{7.0, 4.0, 0.5};
  const SearchWindow window{{7.2, 3.8, 0.45}, 0.5, 0.1};
  const std::vector<Point2> points = testing::ends_seen(truth);
  const auto match = office_matcher().match(points, window, 0.1);
  ASSERT_TRUE(match);
  EXPECT_DOUBLE_EQ(match->score, best_score_by_trying(office_grid(), points, window));
}

TEST(BranchAndBoundMatcher, SaysNothingWhereNoPoseReachesTheScore) {
  std::vector<Point2> points;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(-6.0, 6.0);
  for (int i = 0; i < 100; ++i) points.emplace_back(coordinate(random), coordinate(random));
  EXPECT_FALSE(office_matcher().match(points, {}, 0.6));
}

TEST(BranchAndBoundMatcher, StaysInItsWindow) {
  const auto match = office_matcher().match(testing::ends_seen({13.0, 3.5, 3.0}),
                                            {{2.0, 4.0, 0.0}, 1.0, 0.5}, 0.0);
  ASSERT_TRUE(match);
  EXPECT_LE(std::abs(match->T_map_base_link.x - 2.0), 1.05);
  EXPECT_LE(std::abs(match->T_map_base_link.y - 4.0), 1.05);
  EXPECT_LE(std::abs(match->T_map_base_link.yaw), 0.55);
}

TEST(ThinAdaptively, KeepsTheNumberOfPointsAskedFor) {
  std::vector<Point2> wall;
  for (int i = 0; i < 2000; ++i) wall.emplace_back(0.01 * i, 0.0);
  const std::size_t kept = thin_adaptively(wall, 200, 0.5).size();
  EXPECT_GE(kept, 200U);
  EXPECT_LE(kept, 230U);
}

TEST(ThinAdaptively, LeavesAFewPointsAsTheyAre) {
  const std::vector<Point2> points = {{0, 0}, {0.001, 0}, {0.002, 0}};
  EXPECT_EQ(thin_adaptively(points, 200, 0.5).size(), 3U);
}

}  // namespace
}  // namespace cornerfix::bench

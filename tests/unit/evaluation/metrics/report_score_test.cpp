#include "evaluation/metrics/report_score.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace cornerfix::evaluation {
namespace {

TEST(RankCorrelation, IsThatOfTheRanksNotOfTheValues) {
  const std::vector<double> values{1.0, 2.0, 3.0, 4.0};
  EXPECT_DOUBLE_EQ(rank_correlation(values, std::vector{1.0, 10.0, 100.0, 1000.0}), 1.0);
  EXPECT_DOUBLE_EQ(rank_correlation(values, std::vector{9.0, 7.0, 2.0, -5.0}), -1.0);
}

TEST(RankCorrelation, GivesEqualValuesTheirMeanRank) {
  // Ranks 0, 1.5, 1.5, 3 against 0, 1, 2, 3: 4.5 / sqrt(4.5 * 5).
  EXPECT_NEAR(rank_correlation(std::vector{1.0, 2.0, 2.0, 3.0}, std::vector{1.0, 2.0, 3.0, 4.0}),
              0.9487, 1e-4);
}

TEST(RankCorrelation, IsNothingWhereAllValuesAreEqual) {
  EXPECT_EQ(rank_correlation(std::vector{2.0, 2.0, 2.0}, std::vector{1.0, 2.0, 3.0}), 0.0);
}

AssessedPlace place_with(const Pose2& T_map_start, double way_m) {
  AssessedStart start;
  start.T_map_base_link = T_map_start;
  start.way_m = way_m;
  return {T_map_start.translation(), 0, {start}};
}

TEST(PredictedDistance, IsThatOfTheStartsNearby) {
  LocalizabilityReport report;
  report.lattice_m = 2.0;
  report.places = {place_with({0, 0, 0}, 1.0), place_with({10, 0, 0}, 9.0)};
  EXPECT_NEAR(predicted_distance_m(report, {0.5, 0.0, 0.0}), 1.0, 1e-6);
  EXPECT_NEAR(predicted_distance_m(report, {9.0, 1.0, 0.3}), 9.0, 1e-6);
  EXPECT_NEAR(predicted_distance_m(report, {5.0, 0.0, 0.0}), 5.0, 1e-6);
}

TEST(PredictedDistance, MindsWhereTheRobotLooks) {
  LocalizabilityReport report;
  report.lattice_m = 2.0;
  report.places = {place_with({0, 0, 0}, 1.0), place_with({0, 0, std::numbers::pi}, 9.0)};
  EXPECT_LT(predicted_distance_m(report, {0.0, 0.0, 0.2}), 1.1);
  EXPECT_GT(predicted_distance_m(report, {0.0, 0.0, -3.0}), 8.9);
}

}  // namespace
}  // namespace cornerfix::evaluation

#include "evaluation/metrics/reliability.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace cornerfix::evaluation {
namespace {

std::vector<Forecast> forecasts_of(double confidence, int correct, int wrong) {
  std::vector<Forecast> forecasts(static_cast<std::size_t>(correct), {confidence, true});
  forecasts.insert(forecasts.end(), static_cast<std::size_t>(wrong), {confidence, false});
  return forecasts;
}

TEST(Reliability, BinsCoverTheRangeWithoutGaps) {
  const auto bins = reliability_of({});
  EXPECT_EQ(bins.front().from, 0.0);
  EXPECT_EQ(bins.back().to, 1.0);
  for (std::size_t i = 1; i < bins.size(); ++i) EXPECT_EQ(bins[i].from, bins[i - 1].to);
}

TEST(Reliability, CountsEveryForecastOnceTheLimitsIncluded) {
  std::vector<Forecast> forecasts;
  for (const double confidence : {0.0, 0.05, 0.1, 0.55, 0.995, 0.9979, 0.998, 1.0})
    forecasts.push_back({confidence, true});
  const auto bins = reliability_of(forecasts);
  std::size_t all = 0;
  for (const ReliabilityBin& bin : bins) {
    all += bin.forecasts;
    if (bin.forecasts == 0) continue;
    EXPECT_GE(bin.mean_confidence, bin.from);
    EXPECT_LE(bin.mean_confidence, bin.to);
  }
  EXPECT_EQ(all, forecasts.size());
  EXPECT_EQ(bins.front().forecasts, 2U);
  EXPECT_EQ(bins.back().forecasts, 2U);
}

TEST(Reliability, OfHonestForecastsHasNoCalibrationError) {
  EXPECT_NEAR(expected_calibration_error(reliability_of(forecasts_of(0.75, 75, 25))), 0.0, 1e-12);
}

TEST(Reliability, OfBoastfulForecastsHasTheDifference) {
  EXPECT_NEAR(expected_calibration_error(reliability_of(forecasts_of(0.996, 6, 4))), 0.396, 1e-12);
}

TEST(Reliability, WithoutForecastsHasNoCalibrationError) {
  EXPECT_EQ(expected_calibration_error(reliability_of({})), 0.0);
}

}  // namespace
}  // namespace cornerfix::evaluation

#include "evaluation/metrics/reliability.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cornerfix::evaluation {

namespace {

constexpr std::array kEdges{0.0, 0.1, 0.2,  0.3,  0.4,   0.5,   0.6,   0.7,
                            0.8, 0.9, 0.95, 0.98, 0.990, 0.995, 0.998, 1.0};

std::size_t bin_of(double confidence) {
  const auto inner_end = kEdges.end() - 1;
  const auto above = std::upper_bound(kEdges.begin() + 1, inner_end, confidence);
  return static_cast<std::size_t>(above - kEdges.begin()) - 1;
}

}  // namespace

std::vector<ReliabilityBin> reliability_of(const std::vector<Forecast>& forecasts) {
  std::vector<ReliabilityBin> bins(kEdges.size() - 1);
  for (std::size_t i = 0; i < bins.size(); ++i) {
    bins[i].from = kEdges[i];
    bins[i].to = kEdges[i + 1];
  }
  for (const Forecast& forecast : forecasts) {
    ReliabilityBin& bin = bins[bin_of(forecast.confidence)];
    ++bin.forecasts;
    bin.correct += forecast.correct ? 1 : 0;
    bin.mean_confidence += forecast.confidence;
  }
  for (ReliabilityBin& bin : bins)
    bin.mean_confidence /= static_cast<double>(std::max<std::size_t>(1, bin.forecasts));
  return bins;
}

double expected_calibration_error(const std::vector<ReliabilityBin>& bins) {
  double error = 0.0;
  double forecasts = 0.0;
  for (const ReliabilityBin& bin : bins) {
    const auto n = static_cast<double>(bin.forecasts);
    error += std::abs(n * bin.mean_confidence - static_cast<double>(bin.correct));
    forecasts += n;
  }
  return forecasts > 0.0 ? error / forecasts : 0.0;
}

}  // namespace cornerfix::evaluation

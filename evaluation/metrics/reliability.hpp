/// \file  Whether probabilities hold: reliability table and expected calibration error.
#pragma once

#include <cstddef>
#include <vector>

namespace cornerfix::evaluation {

/// A pose that was believed with a probability, and whether it was correct.
struct Forecast {
  double confidence = 0.0;  ///< In [0, 1].
  bool correct = false;
};

/// Forecasts of similar confidence.
struct ReliabilityBin {
  double from = 0.0;  ///< Included.
  double to = 1.0;    ///< Not included but in the last bin.
  std::size_t forecasts = 0;
  std::size_t correct = 0;
  double mean_confidence = 0.0;  ///< 0 in an empty bin.
};

/// Tenths of the range, and finer bins above 0.9, where poses are accepted.
[[nodiscard]] std::vector<ReliabilityBin> reliability_of(const std::vector<Forecast>& forecasts);

/// Mean over the forecasts of the difference between a bin's mean confidence and its share of
/// correct ones (Naeini et al. 2015). 0 without forecasts.
[[nodiscard]] double expected_calibration_error(const std::vector<ReliabilityBin>& bins);

}  // namespace cornerfix::evaluation

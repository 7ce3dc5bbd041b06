/// \file  Percentiles and means of measured values: the one definition, for every score.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

namespace cornerfix::evaluation {

/// The value below which a `share` of the values lies; NaN without values.
[[nodiscard]] inline double percentile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::ranges::sort(values);
  const auto index = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  return values[std::min(values.size() - 1, index)];
}

/// NaN without values.
[[nodiscard]] inline double mean(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// As figures are printed.
[[nodiscard]] inline double to_four_decimals(double value) { return std::round(1e4 * value) / 1e4; }

}  // namespace cornerfix::evaluation

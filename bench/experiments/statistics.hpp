/// \file  Means and percentiles of what was measured.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

namespace cornerfix::bench {

/// NaN for no values.
[[nodiscard]] inline double mean(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// The value that the share `share` of all lies below; NaN for no values.
[[nodiscard]] inline double percentile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto index = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::min(values.size() - 1, index));
  std::ranges::nth_element(values, nth);
  return *nth;
}

}  // namespace cornerfix::bench

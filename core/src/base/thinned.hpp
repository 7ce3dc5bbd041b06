/// \file  Some of many points, evenly taken.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// At most `count` of `points`, evenly spaced in their order.
[[nodiscard]] inline std::vector<Point2> thinned(std::span<const Point2> points,
                                                 std::size_t count) {
  const std::size_t n = std::min(points.size(), count);
  std::vector<Point2> kept;
  kept.reserve(n);
  for (std::size_t i = 0; i < n; ++i) kept.push_back(points[i * points.size() / n]);
  return kept;
}

}  // namespace cornerfix

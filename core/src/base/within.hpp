/// \file  The points near the origin of their frame.
#pragma once

#include <algorithm>
#include <iterator>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// Hits that judge poses from matched corners [m]: their heading is not accurate enough for farther
/// ones.
inline constexpr double kCoarseReach = 15.0;

/// The points at most `radius_m` from the origin, in their order.
[[nodiscard]] inline std::vector<Point2> within(std::span<const Point2> points, double radius_m) {
  std::vector<Point2> near;
  std::ranges::copy_if(points, std::back_inserter(near),
                       [radius_m](const Point2& p) { return p.norm() <= radius_m; });
  return near;
}

}  // namespace cornerfix

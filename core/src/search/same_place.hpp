/// \file  What counts as one place of a map, and how a guess becomes it.
#pragma once

#include <cstddef>
#include <span>

#include <cornerfix/pose2.hpp>

#include "core/src/base/thinned.hpp"
#include "core/src/matching/scan_refiner.hpp"

namespace cornerfix {

inline constexpr double kDistinctDistance = 1.0;  ///< Places nearer than this [m] and
inline constexpr double kDistinctAngle = 0.26;    ///< turned by less than this [rad] are one.
inline constexpr double kMinPlaceWeight =
    -0.5;  ///< Mean log-likelihood of a hit below which a place is none [nat].

[[nodiscard]] inline bool is_same_place(const Pose2& a, const Pose2& b) {
  return distance(a, b) < kDistinctDistance && angle_between(a, b) < kDistinctAngle;
}

/// Lays hits on the walls about a guess, coarsely, then finely.
[[nodiscard]] inline Pose2 refined_coarse_to_fine(const DistanceField& field,
                                                  std::span<const Point2> ends, Pose2 T_map_frame) {
  constexpr std::size_t kRefinePoints = 200;
  const std::vector<Point2> points = thinned(ends, kRefinePoints);
  for (const double kernel_m : {0.4, 0.1}) {
    T_map_frame =
        aligned_pose(field, points, T_map_frame, {.kernel_m = kernel_m, .max_iterations = 8});
  }
  return T_map_frame;
}

}  // namespace cornerfix

/// \file  What a transform in space is in the plane of the floor.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// A laser's z axis must be within 25 degrees of the vertical.
inline const double kLeastUpright = std::cos(25.0 * std::numbers::pi / 180.0);

/// Position and heading of the x axis, seen from above.
[[nodiscard]] inline Pose2 floor_pose(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T(1, 0), T(0, 0))};
}

/// How upright a laser stands: 1, or -1 when it hangs upside down.
[[nodiscard]] inline double uprightness(const Eigen::Isometry3d& T) { return T(2, 2); }

}  // namespace cornerfix

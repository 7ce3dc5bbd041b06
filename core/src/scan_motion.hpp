/// \file  What laying a scan on a submap begins with: its points, and what is known of its pose.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/scan_refiner.hpp>

#include "thinned.hpp"

namespace cornerfix {

/// As many scans in a row that do not match: the submap does not go on with them.
inline constexpr int kMaxStrayScans = 3;
inline constexpr double kMinMatchedShare = 0.3;  ///< Of the points of a scan that matches.

/// The returns of a scan in base_link, as many as a match needs.
[[nodiscard]] inline std::vector<Point2> points_to_match(const LaserScan& scan,
                                                         const Pose2& T_base_link_laser) {
  constexpr std::size_t kMatchPoints = 360;  // evenly thinned; more do not make the pose better
  std::vector<Point2> points = thinned(returns_as_points(scan), kMatchPoints);
  const double c = std::cos(T_base_link_laser.yaw);
  const double s = std::sin(T_base_link_laser.yaw);
  for (Point2& p : points) {
    p = {T_base_link_laser.x + c * p.x() - s * p.y(), T_base_link_laser.y + s * p.x() + c * p.y()};
  }
  return points;
}

/// How sure odometry is of a motion; without it the motion is that of the scan before, a guess.
[[nodiscard]] inline PosePrior motion_prior(const Pose2& T_submap_base_link, const Pose2& motion,
                                            bool has_odometry) {
  const double way = std::hypot(motion.x, motion.y);
  const double turn = std::abs(motion.yaw);
  if (has_odometry)
    return isotropic_prior(T_submap_base_link, 0.02 + 0.1 * way, 0.01 + 0.1 * turn + 0.02 * way);
  return isotropic_prior(T_submap_base_link, 0.15 + 0.5 * way, 0.1 + 0.5 * turn);
}

}  // namespace cornerfix

/// \file  Scans of a program that did not check its numbers, as those of a transform that failed.
#pragma once

#include <cmath>
#include <cornerfix/laser_scan.hpp>

namespace cornerfix {

/// Whether the returns of a scan are points. Ranges and range_max need not be finite.
[[nodiscard]] inline bool has_finite_geometry(const LaserScan& scan,
                                              const Pose2& T_base_link_laser) {
  const double angles = scan.angle_min + scan.angle_increment + T_base_link_laser.yaw;
  const double lengths = scan.range_min + T_base_link_laser.x + T_base_link_laser.y;
  return std::isfinite(angles) && std::isfinite(lengths);
}

/// The same scan without a return.
[[nodiscard]] inline RobotScan without_returns(const RobotScan& scan) {
  RobotScan blank;
  blank.scan.stamp = scan.scan.stamp;
  blank.scan.angle_increment = 1.0;
  blank.scan.range_max = 1.0;
  blank.T_odom_base_link = scan.T_odom_base_link;
  return blank;
}

}  // namespace cornerfix

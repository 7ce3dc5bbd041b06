/// \file  One sweep of a 2D lidar, with the fields of ROS sensor_msgs/LaserScan.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <cornerfix/pose2.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

/// Many drivers report range_max, or a rounded value just below it, for a beam without a return
/// (Hokuyo, Stage, Gazebo). Ranges this close to range_max are no returns [m].
inline constexpr double kRangeMaxTolerance = 0.01;

/// Beam i looks along angle_min + i * angle_increment in the frame `laser`. A range that is NaN,
/// infinite, below range_min, or above range_max - kRangeMaxTolerance is no return. That is never
/// an error and never a point.
struct LaserScan {
  double stamp = 0.0;            ///< [s]
  double angle_min = 0.0;        ///< [rad]
  double angle_increment = 0.0;  ///< [rad]; negative for a clockwise lidar.
  double range_min = 0.0;        ///< [m]
  double range_max = 0.0;        ///< [m]; infinite where the lidar has no limit.
  std::vector<float> ranges;     ///< [m], one a beam.

  [[nodiscard]] double bearing(std::size_t beam) const {
    return angle_min + static_cast<double>(beam) * angle_increment;
  }
  /// Whether the beam hit something. NaN compares false.
  [[nodiscard]] bool has_return(std::size_t beam) const {
    const double range = static_cast<double>(ranges[beam]);
    return range >= range_min && range < range_max - kRangeMaxTolerance && std::isfinite(range) &&
           range > 0.0;
  }
};

/// A scan as a robot posts it.
struct RobotScan {
  LaserScan scan;
  Pose2 T_base_link_laser;                ///< Where the laser is mounted.
  std::optional<Pose2> T_odom_base_link;  ///< Odometry at the stamp, when there is any.
};

/// A scan of a mapping drive.
struct PosedScan {
  LaserScan scan;
  Pose2 T_base_link_laser;
  Pose2 T_map_base_link;
};

/// The first field that no lidar can have (not finite but range_max, range_max <= range_min,
/// increment 0, more than a turn), or nothing. `field` of the error is the field's name.
[[nodiscard]] std::optional<Error> validate(const LaserScan& scan);

/// The returns as points in `laser` [m], in beam order. O(beams).
[[nodiscard]] std::vector<Point2> returns_as_points(const LaserScan& scan);

}  // namespace cornerfix

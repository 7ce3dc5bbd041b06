/// \file  One sweep of a 2D lidar, with the fields of ROS sensor_msgs/LaserScan, and its correction
/// for motion during the sweep.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <cornerfix/pose2.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

/// Many drivers report range_max, or a value just below it, for a beam without a return (Hokuyo,
/// Stage, Gazebo; a SICK S300 reports 29.96 m of 30 m). Ranges this close to range_max are no
/// returns: [m], or the share of range_max if that is more.
inline constexpr double kRangeMaxTolerance = 0.01;
inline constexpr double kRangeMaxToleranceShare = 0.0015;

/// The shortest range that is no return for being close to range_max; infinite without a limit.
[[nodiscard]] inline double no_return_range(double range_max) {
  return std::min(range_max - kRangeMaxTolerance, range_max * (1.0 - kRangeMaxToleranceShare));
}

/// Beam i looks along angle_min + i * angle_increment in the frame `laser`. A range that is NaN,
/// infinite, below range_min, or from no_return_range() on is no return. That is never an error and
/// never a point.
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
    return range >= range_min && range < no_return_range(range_max) && std::isfinite(range) &&
           range > 0.0;
  }
};

/// A scan as a robot posts it.
struct RobotScan {
  LaserScan scan;
  Pose2 T_base_link_laser;                ///< Where the laser is mounted.
  std::optional<Pose2> T_odom_base_link;  ///< Odometry at the stamp, when there is any.
};

/// A scan of a mapping run.
struct PosedScan {
  LaserScan scan;
  Pose2 T_base_link_laser;
  Pose2 T_map_base_link;
};

/// A scan that a localizer keeps in its local map, the submap.
struct SubmapScan {
  std::uint64_t index = 0;  ///< Counts the scans kept since the reset, so it is a stable key.
  LaserScan scan;
  Pose2 T_base_link_laser;
  Pose2 T_submap_base_link;
};
/// A local map and the states that are taken of it share its scans.
using SubmapScanPtr = std::shared_ptr<const SubmapScan>;

/// The first field that no lidar can have (not finite but range_max, range_max <= range_min,
/// increment 0, more than a turn), or nothing. `field` of the error is the field's name.
[[nodiscard]] std::optional<Error> validate(const LaserScan& scan);

/// Leaves out the beams beyond a full turn. A spinning lidar whose driver keeps the increment takes
/// more beams than a turn has when it turns slowly. Scans of more than a turn and a quarter stay as
/// they are, for validate() to refuse. \return Whether beams were left out.
bool cut_to_full_turn(LaserScan& scan);

/// The returns as points in `laser` [m], in beam order. O(beams).
[[nodiscard]] std::vector<Point2> returns_as_points(const LaserScan& scan);

/// How a laser moved while it took a scan.
struct ScanMotion {
  Pose2 T_begin_end;     ///< From the scan's stamp on, for `seconds`; at constant speed.
  double seconds = 0.0;  ///< > 0.
  /// From beam to beam [s], as in sensor_msgs/LaserScan: the first beam is taken at the stamp. If
  /// it is negative, the beams were taken in reverse and the last one at the stamp.
  double time_increment = 0.0;
};

/// Whether a robot may move so fast: 10 m/s, 10 rad/s.
[[nodiscard]] bool is_plausible(const ScanMotion& motion);

/// The scan as a laser would have taken it that stands where this one was at its stamp. Turning
/// changes the angle increment. Driving moves returns to other beams. The nearest return of a beam
/// stays. A single beam without any gets the mean of its neighbours if they are of one surface. A
/// scan whose increment would vanish or change its sign comes back as it is. O(beams).
[[nodiscard]] LaserScan straightened(const LaserScan& scan, const ScanMotion& motion);

/// How a laser is mounted out of the plane of motion: R_base_link_laser is R_z(yaw) R_y(pitch)
/// R_x(roll) [rad]. A laser that hangs upside down has roll pi.
struct LidarTilt {
  double roll = 0.0;
  double pitch = 0.0;
  friend bool operator==(const LidarTilt&, const LidarTilt&) = default;
};

/// The scan as a level laser in the same place would have taken it, if walls are vertical: returns
/// are projected to the plane. O(beams).
[[nodiscard]] LaserScan levelled(const LaserScan& scan, const LidarTilt& tilt);

}  // namespace cornerfix

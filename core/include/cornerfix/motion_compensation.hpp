/// \file  Straightens a scan that was taken while the robot moved.
#pragma once

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/pose2.hpp>

namespace cornerfix {

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
/// changes the angle increment. Driving moves returns to other beams: the nearest return of a beam
/// stays, and a single beam without any gets the mean of its neighbours if they are of one surface.
/// A scan whose increment would vanish or change its sign comes back as it is. O(beams).
[[nodiscard]] LaserScan straightened(const LaserScan& scan, const ScanMotion& motion);

}  // namespace cornerfix

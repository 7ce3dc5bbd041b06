/// \file  Scans of lidars that are not mounted level.
#pragma once

#include <cornerfix/laser_scan.hpp>

namespace cornerfix {

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

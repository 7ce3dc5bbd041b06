#include <cornerfix/laser_scan.hpp>

#include <cmath>
#include <numbers>

#include "core/src/scan/rebinned_scan.hpp"

namespace cornerfix {

LaserScan levelled(const LaserScan& scan, const LidarTilt& tilt) {
  LaserScan level = scan;
  double roll = wrap_angle(tilt.roll);
  if (std::abs(roll) > 0.5 * std::numbers::pi) {
    // Turned about x by pi, which mirrors the bearings.
    roll = wrap_angle(roll - std::numbers::pi);
    level.angle_min = -level.angle_min;
    level.angle_increment = -level.angle_increment;
  }
  if (roll == 0.0 && tilt.pitch == 0.0) return level;
  RebinnedScan rebinned(level);
  for (std::size_t beam = 0; beam < level.ranges.size(); ++beam) {
    if (!level.has_return(beam)) {
      rebinned.put_no_return(beam);
      continue;
    }
    const double range = static_cast<double>(level.ranges[beam]);
    const double x = range * std::cos(level.bearing(beam));
    const double y = range * std::sin(level.bearing(beam));
    // The first two rows of R_y(pitch) R_x(roll).
    rebinned.put(beam, {std::cos(tilt.pitch) * x + std::sin(tilt.pitch) * std::sin(roll) * y,
                        std::cos(roll) * y});
  }
  return std::move(rebinned).finish();
}

}  // namespace cornerfix

#include "cli/scan_parser.hpp"

#include <cmath>

namespace cornerfix::cli {

bool has_geometry_of(const LaserScan& scan, const LaserScan& lidar) {
  constexpr double kAngleTolerance = 1e-3;  // [rad], over all beams
  constexpr double kRangeTolerance = 1e-2;  // [m]
  const auto beams = static_cast<double>(scan.ranges.size());
  return std::abs(scan.angle_min - lidar.angle_min) <= kAngleTolerance &&
         std::abs(scan.angle_increment - lidar.angle_increment) * beams <= kAngleTolerance &&
         std::abs(scan.range_min - lidar.range_min) <= kRangeTolerance &&
         std::abs(scan.range_max - lidar.range_max) <= kRangeTolerance;
}

}  // namespace cornerfix::cli

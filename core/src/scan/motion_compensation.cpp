#include <cornerfix/laser_scan.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>

#include "core/src/scan/rebinned_scan.hpp"

namespace cornerfix {

namespace {

/// Where the laser was in its place at the scan's stamp when it took a beam.
Pose2 laser_at(std::size_t beam, std::size_t beams, const ScanMotion& motion) {
  const std::size_t earlier_beams = motion.time_increment < 0.0 ? beams - 1 - beam : beam;
  const double share =
      static_cast<double>(earlier_beams) * std::abs(motion.time_increment) / motion.seconds;
  return {share * motion.T_begin_end.x, share * motion.T_begin_end.y,
          share * motion.T_begin_end.yaw};
}

/// The geometry that turning alone leaves; empty ranges when there is none.
LaserScan turned_geometry(const LaserScan& scan, const ScanMotion& motion) {
  LaserScan turned = scan;
  const std::size_t beams = scan.ranges.size();
  turned.ranges.clear();
  turned.angle_increment += motion.T_begin_end.yaw * motion.time_increment / motion.seconds;
  turned.angle_min += laser_at(0, beams, motion).yaw;
  if (!(turned.angle_increment * scan.angle_increment > 0.0)) return turned;
  const double full_turn = 2.0 * std::numbers::pi / std::abs(turned.angle_increment);
  turned.ranges.assign(std::min(beams, static_cast<std::size_t>(full_turn) + 1),
                       std::numeric_limits<float>::quiet_NaN());
  return turned;
}

}  // namespace

bool is_plausible(const ScanMotion& motion) {
  constexpr double kMostPerSecond = 10.0;
  const Pose2& T = motion.T_begin_end;
  return std::hypot(T.x, T.y) <= kMostPerSecond * motion.seconds &&
         std::abs(T.yaw) <= kMostPerSecond * motion.seconds;
}

LaserScan straightened(const LaserScan& scan, const ScanMotion& motion) {
  const LaserScan geometry = turned_geometry(scan, motion);
  if (geometry.ranges.empty()) return scan;
  RebinnedScan rebinned(geometry);
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.has_return(beam)) {
      rebinned.put_no_return(beam);
      continue;
    }
    const double bearing = scan.bearing(beam);
    rebinned.put(beam, laser_at(beam, scan.ranges.size(), motion) *
                           (static_cast<double>(scan.ranges[beam]) *
                            Point2(std::cos(bearing), std::sin(bearing))));
  }
  return std::move(rebinned).finish();
}

}  // namespace cornerfix

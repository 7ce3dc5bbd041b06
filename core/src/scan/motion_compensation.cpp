#include <cornerfix/laser_scan.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

namespace cornerfix {

namespace {

constexpr float kNoReturn = std::numeric_limits<float>::quiet_NaN();

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
  turned.ranges.assign(std::min(beams, static_cast<std::size_t>(full_turn) + 1), kNoReturn);
  return turned;
}

/// Fills single beams that nothing moved to, between returns of one surface.
void fill_gaps(const std::vector<bool>& is_taken, std::vector<float>& ranges) {
  constexpr float kSameSurface = 0.1F;  // of the range
  for (std::size_t beam = 1; beam + 1 < ranges.size(); ++beam) {
    const float before = ranges[beam - 1];
    const float after = ranges[beam + 1];
    if (is_taken[beam] || !is_taken[beam - 1] || !is_taken[beam + 1]) continue;
    if (std::abs(before - after) <= kSameSurface * std::min(before, after)) {
      ranges[beam] = 0.5F * (before + after);
    }
  }
}

}  // namespace

bool is_plausible(const ScanMotion& motion) {
  constexpr double kMostPerSecond = 10.0;
  const Pose2& T = motion.T_begin_end;
  return std::hypot(T.x, T.y) <= kMostPerSecond * motion.seconds &&
         std::abs(T.yaw) <= kMostPerSecond * motion.seconds;
}

LaserScan straightened(const LaserScan& scan, const ScanMotion& motion) {
  LaserScan out = turned_geometry(scan, motion);
  if (out.ranges.empty()) return scan;
  std::vector<bool> is_taken(out.ranges.size(), false);
  const auto beams = static_cast<std::ptrdiff_t>(out.ranges.size());
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    auto to = static_cast<std::ptrdiff_t>(beam);
    float range = kNoReturn;
    if (scan.has_return(beam)) {
      const double bearing = scan.bearing(beam);
      const Point2 point =
          laser_at(beam, scan.ranges.size(), motion) *
          (static_cast<double>(scan.ranges[beam]) * Point2(std::cos(bearing), std::sin(bearing)));
      const double aside = wrap_angle(std::atan2(point.y(), point.x()) - out.bearing(beam));
      to += std::lround(aside / out.angle_increment);
      range = static_cast<float>(point.norm());
    }
    if (to < 0 || to >= beams) continue;
    const auto taken = static_cast<std::size_t>(to);
    if (is_taken[taken] && !(range < out.ranges[taken]) && !std::isnan(out.ranges[taken])) continue;
    is_taken[taken] = true;
    out.ranges[taken] = range;
  }
  fill_gaps(is_taken, out.ranges);
  return out;
}

}  // namespace cornerfix

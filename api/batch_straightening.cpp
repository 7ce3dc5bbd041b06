#include "api/batch_straightening.hpp"

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix::api {
namespace {

constexpr double kLongestScan = 1.0;   // [s]; what claims more is no time.
constexpr double kLongestPause = 1.0;  // [s] between scans, to know the speed.

/// The laser's motion from one scan to the next, or nothing when it is not known.
std::optional<ScanMotion> motion_between(const BatchScan& from, const BatchScan& to,
                                         const Pose2& T_base_link_laser) {
  const bool has_odometry = from.T_odom_base_link && to.T_odom_base_link;
  const auto& T_begin = has_odometry ? from.T_odom_base_link : from.T_map_base_link;
  const auto& T_end = has_odometry ? to.T_odom_base_link : to.T_map_base_link;
  if (!T_begin || !T_end) return std::nullopt;
  ScanMotion motion;
  motion.T_begin_end = inverse(*T_begin * T_base_link_laser) * (*T_end * T_base_link_laser);
  motion.seconds = to.scan.stamp - from.scan.stamp;
  const bool is_known =
      motion.seconds > 0.0 && motion.seconds <= kLongestPause && is_plausible(motion);
  return is_known ? std::optional(motion) : std::nullopt;
}

}  // namespace

void straighten(std::vector<BatchScan>& scans, const Pose2& T_base_link_laser) {
  for (std::size_t i = 0; i < scans.size(); ++i) {
    BatchScan& scan = scans[i];
    const double seconds =
        std::abs(scan.time_increment) * static_cast<double>(scan.scan.ranges.size());
    if (!(seconds > 0.0 && seconds <= kLongestScan)) continue;
    std::optional<ScanMotion> motion;
    if (i + 1 < scans.size()) motion = motion_between(scan, scans[i + 1], T_base_link_laser);
    if (!motion && i > 0) motion = motion_between(scans[i - 1], scan, T_base_link_laser);
    if (!motion) continue;
    motion->time_increment = std::exchange(scan.time_increment, 0.0);
    scan.scan = straightened(scan.scan, *motion);
  }
}

}  // namespace cornerfix::api

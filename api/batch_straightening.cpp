#include "api/batch_straightening.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix::api {
namespace {

constexpr double kLongestScan = 1.0;   // [s]; what claims more is no time.
constexpr double kLongestPause = 1.0;  // [s] between scans, to know the speed.

/// The laser's motion from one scan to the next, or nothing when it is not known.
std::optional<ScanMotion> motion_between(const BatchScan& from, const BatchScan& to) {
  const bool has_odometry = from.T_odom_base_link && to.T_odom_base_link;
  const auto& T_begin = has_odometry ? from.T_odom_base_link : from.T_map_base_link;
  const auto& T_end = has_odometry ? to.T_odom_base_link : to.T_map_base_link;
  if (!T_begin || !T_end) return std::nullopt;
  ScanMotion motion;
  motion.T_begin_end = inverse(*T_begin * from.T_base_link_laser) * (*T_end * to.T_base_link_laser);
  motion.seconds = to.scan.stamp - from.scan.stamp;
  const bool is_known =
      motion.seconds > 0.0 && motion.seconds <= kLongestPause && is_plausible(motion);
  return is_known ? std::optional(motion) : std::nullopt;
}

}  // namespace

void straighten(std::vector<BatchScan>& scans) {
  for (auto here = scans.begin(); here != scans.end(); ++here) {
    BatchScan& scan = *here;
    const auto is_same_laser = [&](const BatchScan& other) {
      return other.T_base_link_laser == scan.T_base_link_laser;
    };
    const double seconds =
        std::abs(scan.time_increment) * static_cast<double>(scan.scan.ranges.size());
    if (!(seconds > 0.0 && seconds <= kLongestScan)) continue;
    std::optional<ScanMotion> motion;
    const auto next = std::find_if(here + 1, scans.end(), is_same_laser);
    if (next != scans.end()) motion = motion_between(scan, *next);
    const auto before = std::find_if(std::make_reverse_iterator(here), scans.rend(), is_same_laser);
    if (!motion && before != scans.rend()) motion = motion_between(*before, scan);
    if (!motion) continue;
    motion->time_increment = std::exchange(scan.time_increment, 0.0);
    scan.scan = straightened(scan.scan, *motion);
  }
}

}  // namespace cornerfix::api

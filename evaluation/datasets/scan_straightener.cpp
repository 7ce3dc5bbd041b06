#include "evaluation/datasets/scan_straightener.hpp"

#include <cmath>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix::evaluation {

namespace {

constexpr double kLongestScan = 1.0;   // [s]; what claims more is no time.
constexpr double kLongestPause = 1.0;  // [s] between scans, to know the speed.

/// From one scan to the next, or nothing when it is not known.
std::optional<ScanMotion> motion_between(const LogScan* from, const LogScan* to) {
  if (from == nullptr || to == nullptr || to->begins_run) return std::nullopt;
  ScanMotion motion;
  motion.seconds = to->scan.stamp - from->scan.stamp;
  if (!(motion.seconds > 0.0 && motion.seconds <= kLongestPause)) return std::nullopt;
  if (from->T_odom_laser && to->T_odom_laser) {
    motion.T_begin_end = inverse(*from->T_odom_laser) * *to->T_odom_laser;
  } else if (from->T_map_laser && to->T_map_laser) {
    motion.T_begin_end = inverse(*from->T_map_laser) * *to->T_map_laser;
  } else {
    return std::nullopt;
  }
  if (!is_plausible(motion)) return std::nullopt;
  return motion;
}

}  // namespace

void ScanStraightener::straighten(LogScan& scan, const LogScan* after) {
  const double seconds =
      std::abs(scan.time_increment) * static_cast<double>(scan.scan.ranges.size());
  if (seconds > 0.0 && seconds <= kLongestScan) {
    auto motion = motion_between(&scan, after);
    if (!motion) motion = motion_between(before_ ? &*before_ : nullptr, &scan);
    if (motion) {
      motion->time_increment = scan.time_increment;
      scan.scan = straightened(scan.scan, *motion);
    } else {
      ++crooked_;
    }
  }
  before_ = LogScan{};
  before_->scan.stamp = scan.scan.stamp;
  before_->T_odom_laser = scan.T_odom_laser;
  before_->T_map_laser = scan.T_map_laser;
}

std::string ScanStraightener::note() const {
  if (crooked_ == 0) return "";
  return std::to_string(crooked_) +
         " scans were taken beam by beam and are used as they are: their motion is not known";
}

}  // namespace cornerfix::evaluation

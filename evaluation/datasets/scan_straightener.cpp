#include "evaluation/datasets/scan_straightener.hpp"

#include <cmath>
#include <cstdio>

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

std::string claim_text(const LogScan& scan, double seconds) {
  char text[96];
  std::snprintf(text, sizeof text, "%.6g s times %zu beams are %.6g s", scan.time_increment,
                scan.scan.ranges.size(), seconds);
  return text;
}

}  // namespace

void ScanStraightener::straighten(LogScan& scan, const LogScan* after) {
  const double seconds =
      std::abs(scan.time_increment) * static_cast<double>(scan.scan.ranges.size());
  if (seconds > kLongestScan) {
    if (too_long_++ == 0) first_too_long_ = claim_text(scan, seconds);
  } else if (seconds > 0.0) {
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

std::vector<std::string> ScanStraightener::notes() const {
  std::vector<std::string> notes;
  if (crooked_ > 0) {
    notes.push_back(std::to_string(crooked_) +
                    " scans were taken beam by beam and are used as they are: their motion is not "
                    "known");
  }
  if (too_long_ > 0) {
    notes.push_back("time_increment cannot be right in " + std::to_string(too_long_) +
                    " scans, in the first " + first_too_long_ +
                    ", expected at most 1 s: these are used as they are, --scan-time straightens "
                    "them");
  }
  return notes;
}

}  // namespace cornerfix::evaluation

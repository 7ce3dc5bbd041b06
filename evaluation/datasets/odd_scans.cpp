#include "evaluation/datasets/odd_scans.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cornerfix::evaluation {

namespace {

constexpr double kFarthestReturn = 500.0;  // [m]; 2D lidars see 100 m and less.
constexpr double kLongGap = 20.0;          // [s]; scans 25 ms apart, in milliseconds, are above.
constexpr std::size_t kFewestGaps = 5;

/// A yaw in degrees shows in turns alone, and odometry may jump now and then.
constexpr std::size_t kFewestMotions = 5;
constexpr std::size_t kLeastShareOfMotions = 20;  // one of so many

/// Drivers disagree whether angle_max is that of the last beam or of the one behind it, and some
/// leave out beams at the end.
constexpr double kAngleSlackShare = 0.05;
constexpr double kAngleSlackBeams = 2.0;

std::string rounded_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string share_text(std::size_t part, std::size_t whole) {
  return std::to_string(std::lround(100.0 * static_cast<double>(part) /
                                    static_cast<double>(std::max<std::size_t>(whole, 1)))) +
         " %";
}

/// Whether more than half are odd.
bool are_most(std::size_t odd, std::size_t all) { return 2 * odd > all; }

}  // namespace

void OddScans::look_at(const LogScan& scan) {
  ++scans_;
  look_at_ranges(scan.scan);
  look_at_angles(scan);
  look_at_stamp(scan.scan.stamp);
  look_at_odometry(scan);
}

void OddScans::look_at_ranges(const LaserScan& scan) {
  std::size_t returns = 0;
  std::size_t far = 0;
  std::size_t below = 0;
  std::size_t above = 0;
  double longest = 0.0;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const double range = static_cast<double>(scan.ranges[beam]);
    if (!std::isfinite(range)) continue;
    longest = std::max(longest, range);
    if (scan.has_return(beam)) {
      ++returns;
      far += range > kFarthestReturn ? 1 : 0;
    } else if (range >= no_return_range(scan.range_max)) {
      ++above;
    } else {
      ++below;
    }
  }
  if (returns > 0 && are_most(far, returns) && far_++ == 0) far_range_ = longest;
  if (returns > 0) return;
  if (without_return_++ == 0) {
    limits_ = "range_min " + rounded_text(scan.range_min) + " m, range_max " +
              rounded_text(scan.range_max) + " m";
  }
  ranges_ += scan.ranges.size();
  not_finite_ += scan.ranges.size() - below - above;
  below_ += below;
  above_ += above;
  longest_range_ = std::max(longest_range_, longest);
}

void OddScans::look_at_angles(const LogScan& scan) {
  if (!scan.stated_angle_max) return;
  const double last = scan.scan.bearing(scan.scan.ranges.size() - 1);
  const double slack = kAngleSlackBeams * std::abs(scan.scan.angle_increment) +
                       kAngleSlackShare * std::abs(last - scan.scan.angle_min);
  if (std::abs(*scan.stated_angle_max - last) <= slack || contradictory_++ > 0) return;
  first_contradiction_ = rounded_text(*scan.stated_angle_max) + " rad, where angle_min " +
                         rounded_text(scan.scan.angle_min) + ", angle_increment " +
                         rounded_text(scan.scan.angle_increment) + " and " +
                         std::to_string(scan.scan.ranges.size()) + " beams end at " +
                         rounded_text(last) + " rad";
}

void OddScans::look_at_stamp(double stamp) {
  const double gap = last_stamp_ ? stamp - *last_stamp_ : 0.0;
  last_stamp_ = stamp;
  if (gap > kLongGap && long_gaps_++ == 0) first_long_gap_ = gap;
}

void OddScans::look_at_odometry(const LogScan& scan) {
  constexpr double kLongestPause = 1.0;  // [s]
  if (!scan.T_odom_laser) return;
  const double seconds = last_odometry_stamp_ ? scan.scan.stamp - *last_odometry_stamp_ : 0.0;
  const ScanMotion motion{.T_begin_end = inverse(T_odom_last_) * *scan.T_odom_laser,
                          .seconds = seconds};
  if (seconds > 0.0 && seconds <= kLongestPause) {
    ++motions_;
    if (!is_plausible(motion) && too_fast_++ == 0) {
      first_too_fast_ = rounded_text(std::hypot(motion.T_begin_end.x, motion.T_begin_end.y)) +
                        " m and " + rounded_text(std::abs(motion.T_begin_end.yaw)) + " rad in " +
                        rounded_text(seconds) + " s";
    }
  }
  last_odometry_stamp_ = scan.scan.stamp;
  T_odom_last_ = *scan.T_odom_laser;
}

std::vector<std::string> OddScans::notes() const {
  std::vector<std::string> notes;
  if (are_most(without_return_, scans_)) notes.push_back(note_of_returns());
  if (are_most(far_, scans_)) {
    notes.push_back("most returns are farther than " + rounded_text(kFarthestReturn) +
                    " m, the farthest of the first scan " + rounded_text(far_range_) +
                    " m: expected metres, are these millimetres?");
  }
  if (contradictory_ > 0) {
    notes.push_back("angle_max does not fit in " + std::to_string(contradictory_) +
                    " scans, in the first it is " + first_contradiction_ +
                    ": angle_increment is used, angle_max is not");
  }
  if (scans_ > kFewestGaps && are_most(long_gaps_, scans_ - 1)) notes.push_back(note_of_stamps());
  if (too_fast_ >= kFewestMotions && kLeastShareOfMotions * too_fast_ > motions_) {
    notes.push_back("the odometry moves faster than 10 m/s or turns faster than 10 rad/s in " +
                    share_text(too_fast_, motions_) + " of the scans, first " + first_too_fast_ +
                    ": expected metres and radians, are these millimetres or degrees?");
  }
  return notes;
}

std::string OddScans::note_of_returns() const {
  std::string note = std::to_string(without_return_) + " of " + std::to_string(scans_) +
                     " scans have no return (" + limits_ + "): of their ranges " +
                     share_text(above_, ranges_) + " are above, " + share_text(below_, ranges_) +
                     " below, " + share_text(not_finite_, ranges_) +
                     " not finite; the longest is " + rounded_text(longest_range_) + " m";
  if (are_most(above_, ranges_)) note += "; expected metres, are these millimetres?";
  return note;
}

std::string OddScans::note_of_stamps() const {
  return "most scans are more than " + rounded_text(kLongGap) + " s apart, first " +
         rounded_text(first_long_gap_) +
         " s: expected stamps in seconds, are these milli- or "
         "microseconds?";
}

}  // namespace cornerfix::evaluation

#include "evaluation/datasets/stamp_order.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>

namespace cornerfix::evaluation {

namespace {

constexpr double kEqualStampStep = 0.01;  // [s]
/// A map takes keyframes more than five minutes after those before for a later run.
constexpr double kRunPause = 600.0;  // [s]

std::string seconds_text(double seconds) {
  char text[48];
  std::snprintf(text, sizeof text, "%.6f s", seconds);
  return text;
}

bool has_same_bits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

}  // namespace

bool StampOrder::take(LogScan& scan, std::optional<double> next, LogFaults& faults) {
  const double recorded = scan.scan.stamp;
  if (is_alone(recorded, next)) {
    faults.add_scan("stamp " + seconds_text(recorded),
                    "not between those of the scans before and behind it, " +
                        seconds_text(last_->scan.stamp) + " and " + seconds_text(*next));
    return false;
  }
  if (last_ && recorded < last_->scan.stamp - kSetBackSeconds) {
    begin_run(scan);
  } else if (last_ && recorded > last_->scan.stamp + kRunPause) {
    note_jump(scan);
  } else if (last_ && recorded < last_->scan.stamp) {
    faults.add_scan("stamp " + seconds_text(recorded),
                    "not after " + seconds_text(last_->scan.stamp) + " of the scan before");
    return false;
  } else if (last_ && is_repeated(scan)) {
    faults.add_scan("stamp " + seconds_text(recorded), "repeats the scan before");
    return false;
  }
  if (last_ && recorded == last_->scan.stamp) ++equal_stamps_;
  const bool is_first = !last_;
  last_ = scan;
  scan.scan.stamp = recorded + shift_;
  if (!is_first && scan.scan.stamp <= last_stamp_) {
    scan.scan.stamp =
        std::max(last_stamp_ + kEqualStampStep,
                 std::nextafter(last_stamp_, std::numeric_limits<double>::infinity()));
  }
  last_stamp_ = scan.scan.stamp;
  return true;
}

void StampOrder::begin_run(LogScan& scan) {
  const double recorded = scan.scan.stamp;
  if (set_backs_++ == 0) {
    first_set_back_ =
        "by " + seconds_text(last_->scan.stamp - recorded) + " to " + seconds_text(recorded);
  }
  shift_ = last_stamp_ + kRunPause - recorded;
  scan.begins_run = true;
}

void StampOrder::note_jump(LogScan& scan) {
  if (jumps_++ == 0) {
    first_jump_ = "by " + seconds_text(scan.scan.stamp - last_->scan.stamp) + " to " +
                  seconds_text(scan.scan.stamp);
  }
  scan.begins_run = true;
}

bool StampOrder::is_alone(double stamp, std::optional<double> next) const {
  if (!last_ || !next || *next < last_->scan.stamp) return false;
  return stamp > *next + kSetBackSeconds || stamp < last_->scan.stamp - kSetBackSeconds;
}

bool StampOrder::is_repeated(const LogScan& scan) const {
  return scan.scan.stamp == last_->scan.stamp &&
         std::ranges::equal(scan.scan.ranges, last_->scan.ranges, has_same_bits);
}

std::vector<std::string> StampOrder::notes() const {
  std::vector<std::string> notes;
  if (set_backs_ > 0) {
    notes.push_back("the clock was set back " + std::to_string(set_backs_) + " times, first " +
                    first_set_back_ + ": a new run begins there, its stamps moved to " +
                    seconds_text(kRunPause) + " after the run before");
  }
  if (jumps_ > 0) {
    notes.push_back("the stamps jump ahead " + std::to_string(jumps_) + " times, first " +
                    first_jump_ + ": a new run begins there");
  }
  if (equal_stamps_ > 0) {
    notes.push_back(std::to_string(equal_stamps_) +
                    " scans have the stamp of the scan before: they keep their order, 10 ms apart");
  }
  return notes;
}

}  // namespace cornerfix::evaluation

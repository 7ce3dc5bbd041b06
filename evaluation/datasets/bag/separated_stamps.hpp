/// \file  Separates scans of one stamp by the time of their recording.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix::evaluation {

/// Some drivers stamp several scans alike: in whole seconds, or by a clock that stands still. Each
/// would get the odometry of the first one.
class SeparatedStamps {
 public:
  /// Moves the stamp on where it is that of the scan before. The same scan again, range for range,
  /// keeps its stamp.
  void place(LaserScan& scan, double received) {
    const bool is_alike = scan.stamp == recorded_stamp_ && !last_ranges_.empty();
    const bool is_repeated = std::ranges::equal(scan.ranges, last_ranges_, is_same);
    recorded_stamp_ = scan.stamp;
    if (is_alike && !is_repeated && received > last_received_) {
      scan.stamp = last_stamp_ + (received - last_received_);
      ++separated_;
    } else if (is_alike) {
      scan.stamp = last_stamp_;
    }
    last_stamp_ = scan.stamp;
    last_received_ = received;
    last_ranges_ = scan.ranges;
  }

  /// What was done, for people; may be empty.
  [[nodiscard]] std::string note() const {
    if (separated_ == 0) return "";
    return std::to_string(separated_) +
           " scans have the stamp of the scan before: they are placed by the time of recording";
  }

 private:
  static bool is_same(float a, float b) { return a == b || (a != a && b != b); }

  double recorded_stamp_ = 0.0;  ///< Of the scan before.
  double last_stamp_ = 0.0;      ///< As given out.
  double last_received_ = 0.0;
  std::vector<float> last_ranges_;
  std::size_t separated_ = 0;
};

}  // namespace cornerfix::evaluation

/// \file  Finds the range that stands for no return where range_max does not show it.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix::evaluation {

/// Drivers code beams without return as one number, such as 65.533, 81.91 or 30 m. Where range_max
/// is well above it, these beams seem to hit a round wall. Such a range is the longest of several
/// scans, and many beams of each of them have exactly it: hits of a wall differ by noise and angle.
class ConstantRange {
 public:
  /// How many scans are looked at together, in front of their use.
  static constexpr std::size_t kScans = 20;

  /// The next scan.
  void look_at(const LaserScan& scan);
  /// Turns what was found so far into no returns.
  void clear(LaserScan& scan);

  /// What was found, for people; may be empty.
  [[nodiscard]] std::string note() const;

 private:
  /// The longest range of a scan.
  struct Longest {
    float range = 0.0F;
    std::size_t hits = 0;     ///< That have it.
    std::size_t returns = 0;  ///< Of the scan.
    std::size_t beams = 0;
  };

  [[nodiscard]] Longest longest_of(const LaserScan& scan) const;
  [[nodiscard]] bool is_found(float range) const;

  std::deque<Longest> longest_;
  std::vector<float> found_;
  std::size_t cleared_ = 0;  ///< Beams.
};

}  // namespace cornerfix::evaluation

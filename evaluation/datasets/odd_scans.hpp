/// \file  What looks wrong about the scans of a log as a whole, though each of them can be used.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

/// Looks at the scans of a log one after the other, as they were recorded. One thread at a time.
class OddScans {
 public:
  void look_at(const LogScan& scan);

  /// What a person should check; empty while all looks usual:
  /// - most scans have no return, or most returns are farther than any 2D lidar sees;
  /// - angle_max contradicts angle_increment and the number of beams;
  /// - most scans are so far apart that their stamps are not seconds;
  /// - the odometry is often faster than a robot, as it is in millimetres and degrees.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  void look_at_ranges(const LaserScan& scan);
  void look_at_angles(const LogScan& scan);
  void look_at_stamp(double stamp);
  void look_at_odometry(const LogScan& scan);
  [[nodiscard]] std::string note_of_returns() const;
  [[nodiscard]] std::string note_of_stamps() const;

  std::size_t scans_ = 0;

  std::size_t without_return_ = 0;  ///< Scans.
  std::size_t ranges_ = 0;          ///< Of these scans, and why they are no returns.
  std::size_t not_finite_ = 0;
  std::size_t below_ = 0;
  std::size_t above_ = 0;
  double longest_range_ = 0.0;
  std::string limits_;      ///< Of the first scan without return.
  std::size_t far_ = 0;     ///< Scans.
  double far_range_ = 0.0;  ///< Of the first far scan.

  std::size_t contradictory_ = 0;  ///< Scans whose angle_max does not fit.
  std::string first_contradiction_;

  std::optional<double> last_stamp_;
  std::size_t long_gaps_ = 0;
  double first_long_gap_ = 0.0;

  std::optional<double> last_odometry_stamp_;
  Pose2 T_odom_last_;
  std::size_t motions_ = 0;  ///< Of the odometry, from scan to scan.
  std::size_t too_fast_ = 0;
  std::string first_too_fast_;
};

}  // namespace cornerfix::evaluation

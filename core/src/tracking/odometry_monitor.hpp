/// \file  Tests odometry against scan matching and estimates per robot how far it can be trusted.
///
/// Wheel odometry fails in ways that its messages do not show: a value that never changes, a driver
/// that hangs, two publishers on one topic, a wrong heading. Scan matching measures the same motion
/// independently, except in directions that the scans do not constrain.
#pragma once

#include <Eigen/Core>
#include <array>

#include <cornerfix/answer.hpp>
#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// Value type. Compares forward motion, sideways motion and turn apart, because odometry that never
/// changes agrees with most scans in two of them. Old comparisons of an axis fade as new ones come
/// that the scans constrain along it, so that distrust lasts through a bare corridor.
class OdometryMonitor {
 public:
  using Sums = std::array<double, 6>;

  OdometryMonitor() = default;
  /// Continues from what sums() returned.
  explicit OdometryMonitor(const Sums& sums) : sums_(sums) {}

  /// Adds one motion of base_link, as odometry and as scan matching measured it. Both are compared
  /// after 0.2 m or 0.2 rad, so the verdict does not depend on the scan rate, and a robot that
  /// stands still tests nothing.
  /// \param match_information  Of x, y, yaw of the matched motion, along the axes of base_link;
  /// singular where the scans do not constrain it.
  void add(const Pose2& odometry, const Pose2& matched, const Eigen::Matrix3d& match_information);

  /// Factors on the standard deviations of odometry along x, y and yaw of base_link, estimated from
  /// the normalized innovations squared; >= 1. Odometry that is wrong sideways may be as wrong
  /// forward, so x and y have the larger factor of both.
  [[nodiscard]] Eigen::Vector3d noise_scale() const;
  /// kUsed, kWeightedDown or kIgnored.
  [[nodiscard]] OdometryUse use() const;

  [[nodiscard]] const Sums& sums() const { return sums_; }

 private:
  void compare(const Pose2& odometry, const Pose2& matched,
               const Eigen::Matrix3d& match_information);

  Pose2 odometry_;  ///< Since the last comparison.
  Pose2 matched_;
  /// Per axis: innovations squared, normalized, and how many of them the scans constrained.
  Sums sums_{};
};

}  // namespace cornerfix

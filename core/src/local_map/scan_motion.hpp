/// \file  What laying a scan on a submap begins with: its points, and what is known of its pose.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <cornerfix/laser_scan.hpp>

#include "core/src/base/thinned.hpp"
#include "core/src/matching/scan_refiner.hpp"

namespace cornerfix {

/// As many scans in a row that do not match: the submap does not go on with them.
inline constexpr int kMaxStrayScans = 3;
inline constexpr double kMinMatchedShare = 0.3;  ///< Of the points of a scan that matches.

/// The returns of a scan in base_link, as many as a match needs.
[[nodiscard]] inline std::vector<Point2> points_to_match(const LaserScan& scan,
                                                         const Pose2& T_base_link_laser) {
  constexpr std::size_t kMatchPoints = 360;  // evenly thinned; more do not make the pose better
  std::vector<Point2> points = thinned(returns_as_points(scan), kMatchPoints);
  const double c = std::cos(T_base_link_laser.yaw);
  const double s = std::sin(T_base_link_laser.yaw);
  for (Point2& p : points) {
    p = {T_base_link_laser.x + c * p.x() - s * p.y(), T_base_link_laser.y + s * p.x() + c * p.y()};
  }
  return points;
}

/// Standard deviations of a motion that wheel odometry measured, along x, y and yaw of base_link.
[[nodiscard]] inline Eigen::Vector3d odometry_noise(const Pose2& motion) {
  const double distance_m = std::hypot(motion.x, motion.y);
  const double turn_rad = std::abs(motion.yaw);
  const double position = 0.02 + 0.1 * distance_m;
  return {position, position, 0.01 + 0.1 * turn_rad + 0.02 * distance_m};
}

/// Variances by which wheel odometry drifts over a motion, along x, y and yaw of base_link
/// [m^2, m^2, rad^2]. They grow with the motion and not with the number of scans, so a robot that
/// stands does not drift.
[[nodiscard]] inline Eigen::Vector3d odometry_drift(const Pose2& motion) {
  constexpr double kPosition = 0.07 * 0.07;   // [m^2/m]
  constexpr double kYaw = 0.02 * 0.02;        // [rad^2/m]
  constexpr double kYawOfTurn = 0.05 * 0.05;  // [rad^2/rad]
  const double distance_m = std::hypot(motion.x, motion.y);
  const double position = kPosition * distance_m;
  return {position, position, kYaw * distance_m + kYawOfTurn * std::abs(motion.yaw)};
}

/// The pose that odometry predicts; `noise_scale` multiplies its standard deviations.
[[nodiscard]] inline PosePrior odometry_prior(
    const Pose2& T_submap_base_link, const Pose2& motion,
    const Eigen::Vector3d& noise_scale = Eigen::Vector3d::Ones()) {
  const Pose2 predicted = T_submap_base_link * motion;
  const Eigen::Vector3d sigma = odometry_noise(motion).cwiseProduct(noise_scale);
  const Eigen::Vector3d information = sigma.cwiseAbs2().cwiseInverse();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(predicted.yaw).toRotationMatrix();
  return {predicted, rotation * information.asDiagonal() * rotation.transpose()};
}

/// The pose of a robot whose odometry did not change. Either it stands or its odometry hangs, so
/// the standard deviations are at least twice those of a small motion. `noise_scale` multiplies the
/// latter.
[[nodiscard]] inline PosePrior standing_prior(
    const Pose2& T_submap_base_link, const Eigen::Vector3d& noise_scale = Eigen::Vector3d::Ones()) {
  constexpr double kPosition = 0.04;  // [m]
  constexpr double kYaw = 0.03;       // [rad]
  const Eigen::Vector3d sigma = odometry_noise({}).cwiseProduct(noise_scale);
  return isotropic_prior(T_submap_base_link, std::max(kPosition, sigma.x()),
                         std::max(kYaw, sigma.z()));
}

/// The pose at constant velocity: `motion` is that between the two scans before.
[[nodiscard]] inline PosePrior constant_velocity_prior(const Pose2& T_submap_base_link,
                                                       const Pose2& motion) {
  const double distance_m = std::hypot(motion.x, motion.y);
  return isotropic_prior(T_submap_base_link * motion, 0.15 + 0.5 * distance_m,
                         0.1 + 0.5 * std::abs(motion.yaw));
}

}  // namespace cornerfix

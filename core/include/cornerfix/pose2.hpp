/// \file  Poses and points in the plane, in REP-103 units: metres, radians, counter-clockwise.
///
/// `T_target_source` takes points of `source` into `target`, so neighbours cancel:
/// `T_map_laser = T_map_base_link * T_base_link_laser`.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

namespace cornerfix {

using Point2 = Eigen::Vector2d;  ///< x, y [m].

/// The same angle in (-pi, pi].
[[nodiscard]] inline double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

/// Position [m] and heading [rad, in (-pi, pi]] of a frame in another; also the transform between
/// them.
struct Pose2 {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;

  [[nodiscard]] Point2 translation() const { return {x, y}; }

  friend bool operator==(const Pose2&, const Pose2&) = default;
};

/// Composition: T_a_c = T_a_b * T_b_c.
[[nodiscard]] inline Pose2 operator*(const Pose2& a, const Pose2& b) {
  const double c = std::cos(a.yaw);
  const double s = std::sin(a.yaw);
  return {a.x + c * b.x - s * b.y, a.y + s * b.x + c * b.y, wrap_angle(a.yaw + b.yaw)};
}

/// A point of the source frame, in the target frame.
[[nodiscard]] inline Point2 operator*(const Pose2& T, const Point2& p) {
  const double c = std::cos(T.yaw);
  const double s = std::sin(T.yaw);
  return {T.x + c * p.x() - s * p.y(), T.y + s * p.x() + c * p.y()};
}

/// T_b_a from T_a_b.
[[nodiscard]] inline Pose2 inverse(const Pose2& T) {
  const double c = std::cos(T.yaw);
  const double s = std::sin(T.yaw);
  return {-(c * T.x + s * T.y), s * T.x - c * T.y, wrap_angle(-T.yaw)};
}

/// Metres between two positions.
[[nodiscard]] inline double distance(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

/// Absolute heading difference in [0, pi].
[[nodiscard]] inline double angle_between(const Pose2& a, const Pose2& b) {
  return std::abs(wrap_angle(a.yaw - b.yaw));
}

}  // namespace cornerfix

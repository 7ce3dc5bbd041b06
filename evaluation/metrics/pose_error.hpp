/// \file  When a pose counts as correct: the one definition, for every score.
#pragma once

#include <numbers>

#include <cornerfix/pose2.hpp>

namespace cornerfix::evaluation {

inline constexpr double kCorrectDistance = 0.5;                          ///< [m]
inline constexpr double kCorrectAngle = 5.0 * std::numbers::pi / 180.0;  ///< [rad]
/// Between two keyframes of a log the reference heading is interpolated and can be 10 deg off.
inline constexpr double kCorrectAngleBetweenKeyframes = 15.0 * std::numbers::pi / 180.0;  ///< [rad]

/// Both >= 0.
struct PoseError {
  double m = 0.0;
  double rad = 0.0;
};

[[nodiscard]] inline PoseError pose_error(const Pose2& pose, const Pose2& reference) {
  return {distance(pose, reference), angle_between(pose, reference)};
}

[[nodiscard]] inline bool is_correct(const PoseError& error, double max_angle = kCorrectAngle) {
  return error.m <= kCorrectDistance && error.rad <= max_angle;
}

}  // namespace cornerfix::evaluation

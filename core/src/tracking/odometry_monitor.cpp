#include "core/src/tracking/odometry_monitor.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/src/local_map/scan_motion.hpp"

namespace cornerfix {
namespace {

constexpr double kDecay = 0.85;  // per comparison of an axis
// One jump must not condemn odometry: its normalized innovation squared counts up to this.
constexpr double kMaxSquaredInnovation = 24.0;
constexpr double kPriorCount = 2.0;  // odometry begins as trusted
constexpr double kWeightedDownScale = 1.8;
constexpr double kIgnoredScale = 3.0;

bool is_long_enough(const Pose2& motion) {
  return std::hypot(motion.x, motion.y) >= 0.2 || std::abs(motion.yaw) >= 0.2;
}

}  // namespace

void OdometryMonitor::add(const Pose2& odometry, const Pose2& matched,
                          const Eigen::Matrix3d& match_information) {
  odometry_ = odometry_ * odometry;
  matched_ = matched_ * matched;
  if (!is_long_enough(odometry_) && !is_long_enough(matched_)) return;
  compare(odometry_, matched_, match_information);
  odometry_ = {};
  matched_ = {};
}

void OdometryMonitor::compare(const Pose2& odometry, const Pose2& matched,
                              const Eigen::Matrix3d& match_information) {
  const Pose2 difference = inverse(odometry) * matched;
  const Eigen::Vector3d innovation{difference.x, difference.y, difference.yaw};
  const Eigen::Vector3d sigma = odometry_noise(odometry);
  // A trace of information keeps the covariance finite along a bare corridor.
  const Eigen::Matrix3d match_covariance =
      (match_information + 1e-3 * Eigen::Matrix3d::Identity()).inverse();
  for (int axis = 0; axis < 3; ++axis) {
    const double odometry_variance = sigma[axis] * sigma[axis];
    const double variance = odometry_variance + match_covariance(axis, axis);
    const double constrained = odometry_variance / variance;
    const double squared =
        std::min(innovation[axis] * innovation[axis] / variance, kMaxSquaredInnovation);
    const double kept = std::pow(kDecay, constrained);
    double& sum = sums_[static_cast<std::size_t>(2 * axis)];
    double& count = sums_[static_cast<std::size_t>(2 * axis + 1)];
    sum = kept * sum + constrained * squared;
    count = kept * count + constrained;
  }
}

Eigen::Vector3d OdometryMonitor::noise_scale() const {
  Eigen::Vector3d scale;
  for (int axis = 0; axis < 3; ++axis) {
    const double sum = sums_[static_cast<std::size_t>(2 * axis)];
    const double count = sums_[static_cast<std::size_t>(2 * axis + 1)];
    scale[axis] = std::sqrt(std::max(1.0, (sum + kPriorCount) / (count + kPriorCount)));
  }
  // The axes of base_link are those of the odometry only while its heading is right.
  scale.head<2>().setConstant(scale.head<2>().maxCoeff());
  return scale;
}

OdometryUse OdometryMonitor::use() const {
  const double scale = noise_scale().maxCoeff();
  if (scale >= kIgnoredScale) return OdometryUse::kIgnored;
  return scale >= kWeightedDownScale ? OdometryUse::kWeightedDown : OdometryUse::kUsed;
}

}  // namespace cornerfix

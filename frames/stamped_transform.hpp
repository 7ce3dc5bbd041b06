/// \file  geometry_msgs/TransformStamped: a transform between two frames at a time.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <string>

namespace cornerfix {

/// Takes points of `child` into `parent` from `stamp` [s] on.
struct StampedTransform {
  double stamp = 0.0;
  std::string parent;
  std::string child;
  Eigen::Isometry3d T_parent_child = Eigen::Isometry3d::Identity();
};

/// Nothing when the translation is not finite or the rotation is no unit quaternion (within 0.1).
[[nodiscard]] inline std::optional<Eigen::Isometry3d> rigid_transform(
    const Eigen::Vector3d& translation, const Eigen::Quaterniond& rotation) {
  if (!translation.allFinite() || !(std::abs(rotation.norm() - 1.0) < 0.1)) return std::nullopt;
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = rotation.normalized().toRotationMatrix();
  transform.translation() = translation;
  return transform;
}

}  // namespace cornerfix

/// \file  Messages of ROS 2 as values of the library.
#pragma once

#include <optional>
#include <vector>

#include "frames/stamped_transform.hpp"
#include "ros2/messages.hpp"
#include "ros2/scan_assembler.hpp"

namespace cornerfix::ros2 {

[[nodiscard]] ReceivedScan received_scan(const LaserScanMessage& message);

/// The pose as the transform from its child frame; nothing when it is no pose.
[[nodiscard]] std::optional<StampedTransform> odometry_transform(const OdometryMessage& message);

/// Those that are no transforms are left out.
[[nodiscard]] std::vector<StampedTransform> transforms(const TfMessage& message);

[[nodiscard]] double seconds(const Time& stamp);
[[nodiscard]] Time ros_time(double seconds);

/// A turn about z.
[[nodiscard]] Quaternion yaw_quaternion(double yaw);

}  // namespace cornerfix::ros2

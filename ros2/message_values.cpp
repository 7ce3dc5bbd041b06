#include "ros2/message_values.hpp"

#include <cmath>
#include <span>

namespace cornerfix::ros2 {

namespace {

template <typename Sequence>
auto elements(const Sequence& sequence) {
  return std::span(sequence._buffer, sequence._length);
}

template <typename Vector>
Eigen::Vector3d vector(const Vector& v) {
  return {v.x, v.y, v.z};
}

Eigen::Quaterniond rotation(const Quaternion& q) { return {q.w, q.x, q.y, q.z}; }

}  // namespace

ReceivedScan received_scan(const LaserScanMessage& message) {
  const auto ranges = elements(message.ranges);
  LaserScan scan{.stamp = seconds(message.header.stamp),
                 .angle_min = static_cast<double>(message.angle_min),
                 .angle_increment = static_cast<double>(message.angle_increment),
                 .range_min = static_cast<double>(message.range_min),
                 .range_max = static_cast<double>(message.range_max),
                 .ranges = {ranges.begin(), ranges.end()}};
  return {message.header.frame_id, std::move(scan), static_cast<double>(message.time_increment)};
}

std::optional<StampedTransform> odometry_transform(const OdometryMessage& message) {
  const auto& pose = message.pose.pose;
  const auto T = rigid_transform(vector(pose.position), rotation(pose.orientation));
  if (!T) return std::nullopt;
  return StampedTransform{seconds(message.header.stamp), message.header.frame_id,
                          message.child_frame_id, *T};
}

std::vector<StampedTransform> transforms(const TfMessage& message) {
  std::vector<StampedTransform> out;
  for (const TransformMessage& item : elements(message.transforms)) {
    const auto T =
        rigid_transform(vector(item.transform.translation), rotation(item.transform.rotation));
    if (!T) continue;
    out.push_back({seconds(item.header.stamp), item.header.frame_id, item.child_frame_id, *T});
  }
  return out;
}

double seconds(const Time& stamp) {
  return static_cast<double>(stamp.sec) + 1e-9 * static_cast<double>(stamp.nanosec);
}

Time ros_time(double seconds) {
  const double whole = std::floor(seconds);
  const double nanoseconds = std::min(std::round((seconds - whole) * 1e9), 999999999.0);
  return {static_cast<std::int32_t>(whole), static_cast<std::uint32_t>(nanoseconds)};
}

Quaternion yaw_quaternion(double yaw) {
  return {0.0, 0.0, std::sin(yaw / 2.0), std::cos(yaw / 2.0)};
}

}  // namespace cornerfix::ros2

/// \file  The messages of a run, of ROS 1 and ROS 2 alike, as far as they are of use here.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/result.hpp>

#include "evaluation/datasets/bag/wire_reader.hpp"
#include "frames/stamped_transform.hpp"

namespace cornerfix::evaluation {

enum class MessageKind { kLaserScan, kMultiEchoScan, kPointCloud, kOdometry, kTransforms };

/// "sensor_msgs/LaserScan", "sensor_msgs/msg/LaserScan"; nothing for a type of no use here.
[[nodiscard]] std::optional<MessageKind> message_kind(std::string_view type);

/// sensor_msgs/LaserScan. The stamp is 0 where the driver left it out.
struct LaserScanMessage {
  std::string frame;
  LaserScan scan;
  double time_increment = 0.0;           ///< From beam to beam [s].
  std::optional<double> angle_max = {};  ///< [rad]; nothing where it is not finite.
};

/// sensor_msgs/PointCloud2. Points that are not finite are left out.
struct PointCloudMessage {
  std::string frame;
  double stamp = 0.0;
  std::vector<Eigen::Vector3f> points;
};

/// tf/tfMessage or tf2_msgs/TFMessage.
struct TransformsMessage {
  std::vector<StampedTransform> transforms;
  std::string fault;  ///< Of the first transform that is left out; empty when there is none.
};

/// Frames come without a leading slash. A message that ends too early, a length that it cannot
/// hold, more beams than any lidar has, numbers that are not finite and rotations that are none are
/// errors.
[[nodiscard]] Result<LaserScanMessage> parse_laser_scan(std::span<const std::byte> bytes,
                                                        WireFormat format);
/// sensor_msgs/MultiEchoLaserScan: the first echo of each beam.
[[nodiscard]] Result<LaserScanMessage> parse_multi_echo_scan(std::span<const std::byte> bytes,
                                                             WireFormat format);
/// Needs fields x, y and z of float32 or float64.
[[nodiscard]] Result<PointCloudMessage> parse_point_cloud(std::span<const std::byte> bytes,
                                                          WireFormat format);
/// nav_msgs/Odometry, as the transform from its child frame.
[[nodiscard]] Result<StampedTransform> parse_odometry(std::span<const std::byte> bytes,
                                                      WireFormat format);
/// Transforms that are not finite or no rotation are left out, as tf2 does.
[[nodiscard]] Result<TransformsMessage> parse_transforms(std::span<const std::byte> bytes,
                                                         WireFormat format);

}  // namespace cornerfix::evaluation

/// \file  Short names for the types that idlc makes of idl/ros_messages.idl.
#pragma once

#include "ros_messages.h"

namespace cornerfix::ros2 {

using DiagnosticArray = diagnostic_msgs_msg_dds__DiagnosticArray_;
using DiagnosticStatus = diagnostic_msgs_msg_dds__DiagnosticStatus_;
using Header = std_msgs_msg_dds__Header_;
using KeyValue = diagnostic_msgs_msg_dds__KeyValue_;
using LaserScanMessage = sensor_msgs_msg_dds__LaserScan_;
using OdometryMessage = nav_msgs_msg_dds__Odometry_;
using PoseMessage = geometry_msgs_msg_dds__PoseWithCovarianceStamped_;
using Quaternion = geometry_msgs_msg_dds__Quaternion_;
using TfMessage = tf2_msgs_msg_dds__TFMessage_;
using Time = builtin_interfaces_msg_dds__Time_;
using TransformMessage = geometry_msgs_msg_dds__TransformStamped_;

/// The descriptor of a message that is a topic's type.
template <typename Message>
[[nodiscard]] const dds_topic_descriptor_t& descriptor();

template <>
inline const dds_topic_descriptor_t& descriptor<DiagnosticArray>() {
  return diagnostic_msgs_msg_dds__DiagnosticArray__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<LaserScanMessage>() {
  return sensor_msgs_msg_dds__LaserScan__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<OdometryMessage>() {
  return nav_msgs_msg_dds__Odometry__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<PoseMessage>() {
  return geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<TfMessage>() {
  return tf2_msgs_msg_dds__TFMessage__desc;
}

}  // namespace cornerfix::ros2

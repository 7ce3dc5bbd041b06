#include "ros2/pose_publisher.hpp"

#include <chrono>

#include "ros2/message_values.hpp"
#include "ros2/topic_names.hpp"

namespace cornerfix::ros2 {

namespace {

/// How long a transform may be used without a new one; amcl's default transform_tolerance.
constexpr double kTransformToleranceS = 1.0;

/// Messages to be written own none of their memory.
char* lent(const std::string& text) { return const_cast<char*>(text.c_str()); }  // NOLINT

template <typename Sequence, typename Element>
void lend(Sequence& sequence, Element* elements, std::size_t count) {
  const auto size = static_cast<std::uint32_t>(count);
  sequence = {size, size, elements, false};
}

Time now() {
  const std::chrono::duration<double> since_1970 =
      std::chrono::system_clock::now().time_since_epoch();
  return ros_time(since_1970.count());
}

/// x, y, yaw of the plane among x, y, z, roll, pitch, yaw.
void fill_covariance(const std::array<double, 9>& planar, double (&out)[36]) {
  constexpr std::array<std::size_t, 3> kAxes = {0, 1, 5};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      out[6 * kAxes[row] + kAxes[column]] = planar[3 * row + column];
    }
  }
}

}  // namespace

Result<void> PosePublisher::open(DdsNode& node, const PoseTopics& topics) {
  auto pose = node.advertise<PoseMessage>(dds_topic(topics.initialpose), kDefault);
  if (!pose) return pose.error();
  pose_ = std::move(*pose);
  auto diagnostics = node.advertise<DiagnosticArray>(dds_topic(topics.diagnostics), kDefault);
  if (!diagnostics) return diagnostics.error();
  diagnostics_ = std::move(*diagnostics);
  if (topics.tf.empty()) return {};
  auto tf = node.advertise<TfMessage>(dds_topic(topics.tf), kTf);
  if (!tf) return tf.error();
  tf_ = std::move(*tf);
  has_tf_ = true;
  return {};
}

void PosePublisher::publish_pose(const LocalizedPose& pose, const std::string& map_frame) {
  const Pose2& T = pose.T_map_base_link;
  PoseMessage message{};
  message.header = {ros_time(pose.stamp), lent(map_frame)};
  message.pose.pose = {{T.x, T.y, 0.0}, yaw_quaternion(T.yaw)};
  fill_covariance(pose.covariance, message.pose.covariance);
  pose_.publish(message);
}

void PosePublisher::publish_transform(const LocalizedPose& pose, const Pose2& T_odom_base_link,
                                      const std::string& map_frame, const std::string& odom_frame) {
  if (!has_tf_) return;
  const Pose2 T_map_odom = pose.T_map_base_link * inverse(T_odom_base_link);
  TransformMessage transform{};
  transform.header = {ros_time(pose.stamp + kTransformToleranceS), lent(map_frame)};
  transform.child_frame_id = lent(odom_frame);
  transform.transform = {{T_map_odom.x, T_map_odom.y, 0.0}, yaw_quaternion(T_map_odom.yaw)};
  TfMessage message{};
  lend(message.transforms, &transform, 1);
  tf_.publish(message);
}

void PosePublisher::publish_diagnosis(const Diagnosis& diagnosis, const std::string& robot) {
  std::vector<KeyValue> values;
  for (const auto& [key, value] : diagnosis.values) values.push_back({lent(key), lent(value)});
  const std::string name = "cornerfix: " + robot;
  DiagnosticStatus status{};
  status.level = static_cast<std::uint8_t>(diagnosis.level);
  status.name = lent(name);
  status.message = lent(diagnosis.message);
  status.hardware_id = lent(robot);
  lend(status.values, values.data(), values.size());
  const std::string no_frame;
  DiagnosticArray message{};
  message.header = {now(), lent(no_frame)};
  lend(message.status, &status, 1);
  diagnostics_.publish(message);
}

}  // namespace cornerfix::ros2

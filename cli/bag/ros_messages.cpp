#include "cli/bag/ros_messages.hpp"

#include <cmath>
#include <utility>

#include "cli/log_reader.hpp"

namespace cornerfix::cli {

namespace {

struct Header {
  double stamp = 0.0;
  std::string frame;
};

Error malformed(std::string message) { return {ErrorCode::kMalformed, std::move(message), ""}; }

std::string frame_name(std::string_view name) {
  if (name.starts_with('/')) name.remove_prefix(1);
  return std::string(name);
}

/// std_msgs/Header; ROS 1 counts messages in it.
Header read_header(WireReader& reader, WireFormat format) {
  if (format == WireFormat::kRos1) reader.number<std::uint32_t>();
  Header header;
  const auto seconds = reader.number<std::uint32_t>();
  const auto nanoseconds = reader.number<std::uint32_t>();
  header.stamp = static_cast<double>(seconds) + 1e-9 * static_cast<double>(nanoseconds);
  header.frame = frame_name(reader.text());
  return header;
}

/// Translation x y z, rotation x y z w; nothing when they are no pose.
std::optional<Eigen::Isometry3d> read_pose(WireReader& reader) {
  Eigen::Vector3d translation;
  for (double& coordinate : translation) coordinate = reader.number<double>();
  Eigen::Quaterniond rotation;
  for (double& coefficient : rotation.coeffs()) coefficient = reader.number<double>();
  const double norm = rotation.norm();
  if (!translation.allFinite() || !(std::abs(norm - 1.0) < 0.1)) return std::nullopt;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = translation;
  return pose;
}

Result<StampedTransform> read_transform(WireReader& reader, WireFormat format) {
  const Header header = read_header(reader, format);
  StampedTransform transform;
  transform.stamp = header.stamp;
  transform.parent = header.frame;
  transform.child = frame_name(reader.text());
  const auto pose = read_pose(reader);
  if (!reader.ok()) return malformed("ends too early");
  if (!pose) return malformed("its pose is not finite or its rotation is no unit quaternion");
  transform.T_parent_child = *pose;
  return transform;
}

}  // namespace

std::optional<MessageKind> message_kind(std::string_view type) {
  const std::size_t package_end = type.find('/');
  const std::size_t name_begin = type.rfind('/');
  if (package_end == std::string_view::npos) return std::nullopt;
  const std::string_view package = type.substr(0, package_end);
  const std::string_view name = type.substr(name_begin + 1);
  if (package == "sensor_msgs" && name == "LaserScan") return MessageKind::kLaserScan;
  if (package == "nav_msgs" && name == "Odometry") return MessageKind::kOdometry;
  if (package == "tf" && name == "tfMessage") return MessageKind::kTransforms;
  if (package == "tf2_msgs" && name == "TFMessage") return MessageKind::kTransforms;
  return std::nullopt;
}

Result<LaserScanMessage> parse_laser_scan(std::span<const std::byte> bytes, WireFormat format) {
  WireReader reader(bytes, format);
  Header header = read_header(reader, format);
  LaserScanMessage message;
  message.frame = std::move(header.frame);
  LaserScan& scan = message.scan;
  scan.stamp = header.stamp;
  scan.angle_min = static_cast<double>(reader.number<float>());
  reader.number<float>();  // angle_max follows from the others
  scan.angle_increment = static_cast<double>(reader.number<float>());
  reader.number<float>();  // time_increment
  reader.number<float>();  // scan_time
  scan.range_min = static_cast<double>(reader.number<float>());
  scan.range_max = static_cast<double>(reader.number<float>());
  const std::size_t beams = reader.count(sizeof(float));
  if (!reader.ok()) return malformed("LaserScan: ends too early");
  if (beams < 2 || beams > LogReader::kMaxBeams) {
    return malformed("LaserScan: " + std::to_string(beams) + " beams, expected 2 to " +
                     std::to_string(LogReader::kMaxBeams));
  }
  scan.ranges.resize(beams);
  for (float& range : scan.ranges) range = reader.number<float>();
  if (const auto error = validate(scan)) {
    return malformed("LaserScan: " + error->field + " " + error->message);
  }
  return message;
}

Result<StampedTransform> parse_odometry(std::span<const std::byte> bytes, WireFormat format) {
  WireReader reader(bytes, format);
  Result<StampedTransform> transform = read_transform(reader, format);
  if (!transform) return malformed("Odometry: " + transform.error().message);
  return transform;
}

Result<std::vector<StampedTransform>> parse_transforms(std::span<const std::byte> bytes,
                                                       WireFormat format) {
  constexpr std::size_t kLeastBytes = 7 * sizeof(double);
  WireReader reader(bytes, format);
  std::vector<StampedTransform> transforms(reader.count(kLeastBytes));
  if (!reader.ok()) return malformed("TFMessage: ends too early");
  for (StampedTransform& transform : transforms) {
    Result<StampedTransform> read = read_transform(reader, format);
    if (!read) return malformed("TFMessage: " + read.error().message);
    transform = std::move(*read);
  }
  return transforms;
}

}  // namespace cornerfix::cli

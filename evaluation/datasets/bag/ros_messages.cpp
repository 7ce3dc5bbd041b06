#include "evaluation/datasets/bag/ros_messages.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <utility>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

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

/// geometry_msgs/TransformStamped, and what Odometry begins with.
struct ReadTransform {
  StampedTransform transform;
  std::string fault;  ///< Empty when it is a pose.
};

std::string fault_of(const StampedTransform& frames, const Eigen::Vector3d& translation,
                     const Eigen::Quaterniond& rotation) {
  char numbers[200];
  std::snprintf(numbers, sizeof numbers,
                "translation %.6g %.6g %.6g, rotation %.6g %.6g %.6g %.6g (x y z w)",
                translation.x(), translation.y(), translation.z(), rotation.x(), rotation.y(),
                rotation.z(), rotation.w());
  return "from " + frames.parent + " to " + frames.child + ": " + numbers +
         ", expected finite numbers and a unit quaternion";
}

Result<ReadTransform> read_transform(WireReader& reader, WireFormat format) {
  const Header header = read_header(reader, format);
  ReadTransform read;
  read.transform.stamp = header.stamp;
  read.transform.parent = header.frame;
  read.transform.child = frame_name(reader.text());
  Eigen::Vector3d translation;
  for (double& coordinate : translation) coordinate = reader.number<double>();
  Eigen::Quaterniond rotation;
  for (double& coefficient : rotation.coeffs()) coefficient = reader.number<double>();
  if (!reader.ok()) return malformed("ends too early");
  if (const auto pose = rigid_transform(translation, rotation)) {
    read.transform.T_parent_child = *pose;
  } else {
    read.fault = fault_of(read.transform, translation, rotation);
  }
  return read;
}

/// LaserScan and MultiEchoLaserScan differ in what a beam is.
template <typename ReadBeam>
Result<LaserScanMessage> parse_scan(std::span<const std::byte> bytes, WireFormat format,
                                    const std::string& type, ReadBeam read_beam) {
  WireReader reader(bytes, format);
  Header header = read_header(reader, format);
  LaserScanMessage message;
  message.frame = std::move(header.frame);
  LaserScan& scan = message.scan;
  scan.stamp = header.stamp;
  scan.angle_min = static_cast<double>(reader.number<float>());
  const double angle_max = static_cast<double>(reader.number<float>());
  if (std::isfinite(angle_max)) message.angle_max = angle_max;
  scan.angle_increment = static_cast<double>(reader.number<float>());
  message.time_increment = static_cast<double>(reader.number<float>());
  reader.number<float>();  // scan_time
  scan.range_min = static_cast<double>(reader.number<float>());
  scan.range_max = static_cast<double>(reader.number<float>());
  const std::size_t beams = reader.count(sizeof(float));
  if (!reader.ok()) return malformed(type + ": ends too early");
  if (beams < 2 || beams > LogReader::kMaxBeams) {
    return malformed(type + ": " + std::to_string(beams) + " beams, expected 2 to " +
                     std::to_string(LogReader::kMaxBeams));
  }
  scan.ranges.resize(beams);
  for (float& range : scan.ranges) range = read_beam(reader);
  if (!reader.ok()) return malformed(type + ": ends too early");
  if (cut_to_full_turn(scan)) message.angle_max.reset();
  if (const auto error = validate(scan)) {
    return malformed(type + ": " + error->field + " " + error->message);
  }
  return message;
}

/// Where a coordinate lies in a point.
struct CloudField {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;  ///< Of a float32 or float64; 0 when there is none.
};

/// sensor_msgs/PointField[]: those of x, y and z.
std::optional<std::array<CloudField, 3>> read_coordinate_fields(WireReader& reader) {
  constexpr std::uint8_t kFloat32 = 7;
  constexpr std::uint8_t kFloat64 = 8;
  constexpr std::size_t kLeastBytes = 13;
  std::array<CloudField, 3> fields{};
  const std::size_t count = reader.count(kLeastBytes);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view name = reader.text();
    const auto offset = reader.number<std::uint32_t>();
    const auto type = reader.number<std::uint8_t>();
    reader.number<std::uint32_t>();  // count
    const std::size_t axis = name.size() == 1 ? std::string_view("xyz").find(name) : 3;
    if (axis >= fields.size()) continue;
    if (type == kFloat32) fields[axis] = {offset, sizeof(float)};
    if (type == kFloat64) fields[axis] = {offset, sizeof(double)};
  }
  const auto is_missing = [](const CloudField& field) { return field.bytes == 0; };
  if (std::ranges::any_of(fields, is_missing)) return std::nullopt;
  return fields;
}

float coordinate(std::span<const std::byte> point, const CloudField& field, bool is_big_endian) {
  std::array<std::byte, sizeof(double)> raw{};
  const auto bytes = point.subspan(field.offset, field.bytes);
  std::ranges::copy(bytes, raw.begin());
  if (is_big_endian)
    std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(field.bytes));
  if (field.bytes == sizeof(double)) {
    const auto value = std::bit_cast<double>(raw);
    const bool fits = std::abs(value) <= std::numeric_limits<float>::max();
    return fits ? static_cast<float>(value) : std::numeric_limits<float>::quiet_NaN();
  }
  std::array<std::byte, sizeof(float)> single{};
  std::copy_n(raw.begin(), single.size(), single.begin());
  return std::bit_cast<float>(single);
}

}  // namespace

std::optional<MessageKind> message_kind(std::string_view type) {
  const std::size_t package_end = type.find('/');
  const std::size_t name_begin = type.rfind('/');
  if (package_end == std::string_view::npos) return std::nullopt;
  const std::string_view package = type.substr(0, package_end);
  const std::string_view name = type.substr(name_begin + 1);
  if (package == "sensor_msgs" && name == "LaserScan") return MessageKind::kLaserScan;
  if (package == "sensor_msgs" && name == "MultiEchoLaserScan") return MessageKind::kMultiEchoScan;
  if (package == "sensor_msgs" && name == "PointCloud2") return MessageKind::kPointCloud;
  if (package == "nav_msgs" && name == "Odometry") return MessageKind::kOdometry;
  if (package == "tf" && name == "tfMessage") return MessageKind::kTransforms;
  if (package == "tf2_msgs" && name == "TFMessage") return MessageKind::kTransforms;
  return std::nullopt;
}

Result<LaserScanMessage> parse_laser_scan(std::span<const std::byte> bytes, WireFormat format) {
  return parse_scan(bytes, format, "LaserScan",
                    [](WireReader& reader) { return reader.number<float>(); });
}

Result<LaserScanMessage> parse_multi_echo_scan(std::span<const std::byte> bytes,
                                               WireFormat format) {
  return parse_scan(bytes, format, "MultiEchoLaserScan", [](WireReader& reader) {
    float first = std::numeric_limits<float>::quiet_NaN();
    const std::size_t echoes = reader.count(sizeof(float));
    for (std::size_t i = 0; i < echoes; ++i) {
      const auto echo = reader.number<float>();
      if (i == 0) first = echo;
    }
    return first;
  });
}

Result<PointCloudMessage> parse_point_cloud(std::span<const std::byte> bytes, WireFormat format) {
  WireReader reader(bytes, format);
  const Header header = read_header(reader, format);
  const std::uint64_t height = reader.number<std::uint32_t>();
  const std::uint64_t width = reader.number<std::uint32_t>();
  const auto fields = read_coordinate_fields(reader);
  const bool is_big_endian = reader.number<std::uint8_t>() != 0;
  const std::uint64_t point_step = reader.number<std::uint32_t>();
  const std::uint64_t stated_row_step = reader.number<std::uint32_t>();
  const std::span<const std::byte> data = reader.bytes(reader.count(1));
  // Some drivers leave the step of a row at 0, or put the width or the size of all rows there.
  const std::uint64_t row_bytes = width * point_step;
  const bool is_packed =
      row_bytes > 0 && data.size() % row_bytes == 0 && data.size() / row_bytes == height;
  const std::uint64_t row_step =
      height == 1 || stated_row_step == 0 || is_packed ? row_bytes : stated_row_step;
  if (!reader.ok()) return malformed("PointCloud2: ends too early");
  if (!fields) return malformed("PointCloud2: expected fields x, y, z of float32 or float64");
  // A product of height and row_step may be beyond 64 bits.
  const bool fits = height == 0 || width == 0 ||
                    (0 < row_bytes && row_bytes <= row_step && height <= data.size() / row_step &&
                     std::ranges::all_of(*fields, [&](const CloudField& field) {
                       return field.offset + field.bytes <= point_step;
                     }));
  if (!fits) {
    return malformed("PointCloud2: " + std::to_string(data.size()) +
                     " bytes of data, where height " + std::to_string(height) + ", width " +
                     std::to_string(width) + ", point_step " + std::to_string(point_step) +
                     " and row_step " + std::to_string(stated_row_step) + " do not fit");
  }
  PointCloudMessage cloud{header.frame, header.stamp, {}};
  for (std::uint64_t row = 0; row < height; ++row) {
    for (std::uint64_t column = 0; column < width; ++column) {
      const auto point = data.subspan(row * row_step + column * point_step, point_step);
      const Eigen::Vector3f position{coordinate(point, (*fields)[0], is_big_endian),
                                     coordinate(point, (*fields)[1], is_big_endian),
                                     coordinate(point, (*fields)[2], is_big_endian)};
      if (position.allFinite()) cloud.points.push_back(position);
    }
  }
  return cloud;
}

Result<StampedTransform> parse_odometry(std::span<const std::byte> bytes, WireFormat format) {
  WireReader reader(bytes, format);
  Result<ReadTransform> read = read_transform(reader, format);
  if (!read) return malformed("Odometry: " + read.error().message);
  if (!read->fault.empty()) return malformed("Odometry: " + read->fault);
  return std::move(read->transform);
}

Result<TransformsMessage> parse_transforms(std::span<const std::byte> bytes, WireFormat format) {
  constexpr std::size_t kLeastBytes = 7 * sizeof(double);
  WireReader reader(bytes, format);
  const std::size_t count = reader.count(kLeastBytes);
  if (!reader.ok()) return malformed("TFMessage: ends too early");
  TransformsMessage message;
  message.transforms.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    Result<ReadTransform> read = read_transform(reader, format);
    if (!read) return malformed("TFMessage: " + read.error().message);
    if (read->fault.empty()) {
      message.transforms.push_back(std::move(read->transform));
    } else if (message.fault.empty()) {
      message.fault = "TFMessage: " + read->fault;
    }
  }
  return message;
}

}  // namespace cornerfix::evaluation

/// \file  The counterpart of WireReader, and the messages of a run in ROS 1's and ROS 2's bytes.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "evaluation/datasets/bag/wire_reader.hpp"

namespace cornerfix::evaluation {

class WireWriter {
 public:
  explicit WireWriter(WireFormat format = WireFormat::kRos1) : format_(format) {
    if (format == WireFormat::kCdr) bytes_.assign("\0\1\0\0", 4);
  }

  template <typename Number>
  WireWriter& number(Number value) {
    if (format_ == WireFormat::kCdr) {
      while ((bytes_.size() - 4) % sizeof value != 0) bytes_.push_back('\0');
    }
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);  // NOLINT
    return *this;
  }

  WireWriter& text(std::string_view text) {
    const bool has_end = format_ == WireFormat::kCdr;
    number(static_cast<std::uint32_t>(text.size() + (has_end ? 1 : 0)));
    bytes_.append(text);
    if (has_end) bytes_.push_back('\0');
    return *this;
  }

  WireWriter& raw(std::string_view bytes) {
    bytes_.append(bytes);
    return *this;
  }

  /// std_msgs/Header.
  WireWriter& header(double stamp, std::string_view frame) {
    if (format_ == WireFormat::kRos1) number(std::uint32_t{7});
    const auto seconds = static_cast<std::uint32_t>(stamp);
    number(seconds);
    number(static_cast<std::uint32_t>((stamp - seconds) * 1e9));
    return text(frame);
  }

  /// Translation and a rotation of `yaw` about z, or of half a turn about x before that.
  WireWriter& pose(double x, double y, double yaw, bool is_upside_down = false) {
    number(x).number(y).number(0.2);
    const double c = std::cos(yaw / 2.0);
    const double s = std::sin(yaw / 2.0);
    return is_upside_down ? number(c).number(s).number(0.0).number(0.0)
                          : number(0.0).number(0.0).number(s).number(c);
  }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  WireFormat format_;
  std::string bytes_;
};

struct WrittenGeometry {
  float angle_min = -1.0F;
  float angle_increment = 1.0F;
  float range_max = 20.0F;
};

/// All of a scan in front of its ranges.
inline void begin_scan(WireWriter& writer, double stamp, std::string_view frame,
                       const WrittenGeometry& geometry) {
  writer.header(stamp, frame);
  for (const float value :
       {geometry.angle_min, 1.0F, geometry.angle_increment, 0.0F, 0.1F, 0.1F, geometry.range_max}) {
    writer.number(value);
  }
}

/// -1, 0 and 1 rad, 0.1 to 20 m, when not said otherwise.
[[nodiscard]] inline std::string laser_scan(WireFormat format, double stamp,
                                            std::vector<float> ranges,
                                            std::string_view frame = "laser",
                                            const WrittenGeometry& geometry = {}) {
  WireWriter writer(format);
  begin_scan(writer, stamp, frame, geometry);
  writer.number(static_cast<std::uint32_t>(ranges.size()));
  for (const float range : ranges) writer.number(range);
  return writer.number(std::uint32_t{0}).bytes();
}

/// Of a MultiEchoLaserScan.
[[nodiscard]] inline std::string multi_echo_scan(WireFormat format, double stamp,
                                                 const std::vector<std::vector<float>>& echoes) {
  WireWriter writer(format);
  begin_scan(writer, stamp, "laser", {});
  writer.number(static_cast<std::uint32_t>(echoes.size()));
  for (const std::vector<float>& beam : echoes) {
    writer.number(static_cast<std::uint32_t>(beam.size()));
    for (const float echo : beam) writer.number(echo);
  }
  return writer.number(std::uint32_t{0}).bytes();
}

struct WrittenPoint {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
};

/// Of a PointCloud2 of one row: intensity, x, y and z as float32.
[[nodiscard]] inline std::string point_cloud(WireFormat format, double stamp,
                                             const std::vector<WrittenPoint>& points,
                                             std::string_view frame = "laser") {
  constexpr std::uint8_t kFloat32 = 7;
  WireWriter writer(format);
  writer.header(stamp, frame);
  const auto width = static_cast<std::uint32_t>(points.size());
  writer.number(std::uint32_t{1}).number(width).number(std::uint32_t{4});
  std::uint32_t offset = 0;
  for (const char* name : {"intensity", "x", "y", "z"}) {
    writer.text(name).number(offset).number(kFloat32).number(std::uint32_t{1});
    offset += sizeof(float);
  }
  writer.number(std::uint8_t{0}).number(offset).number(offset * width).number(offset * width);
  std::string data;
  for (const WrittenPoint& point : points) {
    data += WireWriter().number(1.0F).number(point.x).number(point.y).number(point.z).bytes();
  }
  return writer.raw(data).number(std::uint8_t{1}).bytes();
}

[[nodiscard]] inline std::string odometry(WireFormat format, double stamp, double x, double y,
                                          double yaw, std::string_view parent = "odom",
                                          std::string_view child = "base_link") {
  WireWriter writer(format);
  writer.header(stamp, parent).text(child).pose(x, y, yaw);
  for (int i = 0; i < 36 + 6 + 36; ++i) writer.number(0.0);
  return writer.bytes();
}

struct WrittenTransform {
  std::string parent;
  std::string child;
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
  bool is_upside_down = false;
};

[[nodiscard]] inline std::string transforms(WireFormat format, double stamp,
                                            const std::vector<WrittenTransform>& list) {
  WireWriter writer(format);
  writer.number(static_cast<std::uint32_t>(list.size()));
  for (const WrittenTransform& transform : list) {
    writer.header(stamp, transform.parent).text(transform.child);
    writer.pose(transform.x, transform.y, transform.yaw, transform.is_upside_down);
  }
  return writer.bytes();
}

}  // namespace cornerfix::evaluation

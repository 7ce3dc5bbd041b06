/// \file  The counterpart of WireReader, and the messages of a drive in ROS 1's and ROS 2's bytes.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cli/bag/wire_reader.hpp"

namespace cornerfix::cli {

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

/// -1, 0 and 1 rad, 0.1 to 20 m.
[[nodiscard]] inline std::string laser_scan(WireFormat format, double stamp,
                                            std::vector<float> ranges,
                                            std::string_view frame = "laser") {
  WireWriter writer(format);
  writer.header(stamp, frame);
  for (const float value : {-1.0F, 1.0F, 1.0F, 0.0F, 0.1F, 0.1F, 20.0F}) writer.number(value);
  writer.number(static_cast<std::uint32_t>(ranges.size()));
  for (const float range : ranges) writer.number(range);
  return writer.number(std::uint32_t{0}).bytes();
}

[[nodiscard]] inline std::string odometry(WireFormat format, double stamp, double x, double y,
                                          double yaw) {
  WireWriter writer(format);
  writer.header(stamp, "odom").text("base_link").pose(x, y, yaw);
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

}  // namespace cornerfix::cli

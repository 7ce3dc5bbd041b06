/// \file  Messages of ROS 2 as they are on the wire, written down again by hand: what the client
/// reads and writes with its IDL is checked against this.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace cornerfix::testing::ros {

// each() hands the fields to `f` in the order of the .msg file.

struct Header {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame_id;

  template <typename F>
  void each(F&& f) {
    f(sec), f(nanosec), f(frame_id);
  }
};

struct LaserScan {
  static constexpr const char* kType = "sensor_msgs::msg::dds_::LaserScan_";
  Header header;
  float angle_min = 0.0F;
  float angle_max = 0.0F;
  float angle_increment = 0.0F;
  float time_increment = 0.0F;
  float scan_time = 0.0F;
  float range_min = 0.0F;
  float range_max = 0.0F;
  std::vector<float> ranges;
  std::vector<float> intensities;

  template <typename F>
  void each(F&& f) {
    header.each(f);
    f(angle_min), f(angle_max), f(angle_increment), f(time_increment), f(scan_time);
    f(range_min), f(range_max), f(ranges), f(intensities);
  }
};

struct Pose {
  std::array<double, 3> position{};               ///< x, y, z.
  std::array<double, 4> orientation{0, 0, 0, 1};  ///< x, y, z, w.

  template <typename F>
  void each(F&& f) {
    f(position), f(orientation);
  }
};

struct Odometry {
  static constexpr const char* kType = "nav_msgs::msg::dds_::Odometry_";
  Header header;
  std::string child_frame_id;
  Pose pose;
  std::array<double, 36> pose_covariance{};
  std::array<double, 6> twist{};
  std::array<double, 36> twist_covariance{};

  template <typename F>
  void each(F&& f) {
    header.each(f);
    f(child_frame_id);
    pose.each(f);
    f(pose_covariance), f(twist), f(twist_covariance);
  }
};

struct PoseWithCovarianceStamped {
  static constexpr const char* kType = "geometry_msgs::msg::dds_::PoseWithCovarianceStamped_";
  Header header;
  Pose pose;
  std::array<double, 36> covariance{};

  template <typename F>
  void each(F&& f) {
    header.each(f);
    pose.each(f);
    f(covariance);
  }
};

struct TransformStamped {
  Header header;
  std::string child_frame_id;
  Pose transform;

  template <typename F>
  void each(F&& f) {
    header.each(f);
    f(child_frame_id);
    transform.each(f);
  }
};

/// As a sequence: its length, then one after the other.
template <typename Element, typename F>
void each_of(std::vector<Element>& elements, F&& f) {
  auto size = static_cast<std::uint32_t>(elements.size());
  f(size);
  elements.resize(size);
  for (Element& element : elements) element.each(f);
}

struct TfMessage {
  static constexpr const char* kType = "tf2_msgs::msg::dds_::TFMessage_";
  std::vector<TransformStamped> transforms;

  template <typename F>
  void each(F&& f) {
    each_of(transforms, f);
  }
};

struct KeyValue {
  std::string key;
  std::string value;

  template <typename F>
  void each(F&& f) {
    f(key), f(value);
  }
};

struct DiagnosticStatus {
  std::uint8_t level = 0;
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<KeyValue> values;

  /// "" where there is no such key.
  [[nodiscard]] std::string value(const std::string& key) const {
    for (const KeyValue& pair : values) {
      if (pair.key == key) return pair.value;
    }
    return "";
  }

  template <typename F>
  void each(F&& f) {
    f(level), f(name), f(message), f(hardware_id);
    each_of(values, f);
  }
};

struct DiagnosticArray {
  static constexpr const char* kType = "diagnostic_msgs::msg::dds_::DiagnosticArray_";
  Header header;
  std::vector<DiagnosticStatus> status;

  template <typename F>
  void each(F&& f) {
    header.each(f);
    each_of(status, f);
  }
};

}  // namespace cornerfix::testing::ros

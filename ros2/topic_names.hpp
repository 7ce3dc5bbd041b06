/// \file  Names of ROS 2 topics, and what they are called on the wire.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <cornerfix/result.hpp>

namespace cornerfix::ros2 {

/// Whether ROS 2 accepts it: parts of letters, digits and '_', none beginning with a digit,
/// separated by '/', which may also come first.
[[nodiscard]] bool is_ros_name(std::string_view name);

/// FROM:=TO, as in `--ros-args --remap scan:=front/scan`. Each topic keeps its name or has another.
class Remappings {
 public:
  /// kInvalidArgument where `text` is no FROM:=TO, FROM is none of the topics or TO is no name.
  [[nodiscard]] Result<void> add(std::string_view text);

  /// The full name of a topic: of "scan", "odom", "tf", "tf_static", "initialpose" or
  /// "diagnostics", which may be remapped, or of any other. A name that begins with '/' is full,
  /// any other one is in the namespace.
  [[nodiscard]] std::string resolve(const std::string& topic, const std::string& ns) const;

 private:
  std::map<std::string, std::string, std::less<>> names_;
};

/// Of a topic with a full name: "/scan" is "rt/scan".
[[nodiscard]] std::string dds_topic(const std::string& full_name);

/// What the server calls the lidar of a topic with a full name: "/robot1/front/scan" is
/// "robot1.front.scan".
[[nodiscard]] std::string lidar_name(const std::string& full_name);

}  // namespace cornerfix::ros2

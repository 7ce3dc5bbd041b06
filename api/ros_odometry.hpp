/// \file  nav_msgs/Odometry as rosbridge writes it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include <cornerfix/pose2.hpp>

#include "api/json_field.hpp"

namespace cornerfix::api {

[[nodiscard]] bool is_ros_odometry(const nlohmann::json& json);

/// pose.pose as seen from above, or nothing after adding to the field's errors what was expected.
/// Header, twist and covariances are not used.
[[nodiscard]] std::optional<Pose2> read_ros_odometry(const JsonField& odometry);

}  // namespace cornerfix::api

#include "api/ros_odometry.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace cornerfix::api {
namespace {

/// Of an object with exactly these numbers, in their order.
template <std::size_t kCount>
std::optional<std::array<double, kCount>> read_numbers(
    const JsonField& object, const std::array<std::string_view, kCount>& names) {
  if (!object.expect_object()) return std::nullopt;
  object.expect_members(names);
  std::array<double, kCount> numbers{};
  bool good = true;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto field = object.require(names[i], "a number");
    const auto number = field ? field->as_number() : std::nullopt;
    numbers[i] = number.value_or(0.0);
    good = good && number;
  }
  return good ? std::optional(numbers) : std::nullopt;
}

}  // namespace

bool is_ros_odometry(const nlohmann::json& json) {
  return json.is_object() && json.contains("pose");
}

std::optional<Pose2> read_ros_odometry(const JsonField& odometry) {
  odometry.expect_members({"header", "child_frame_id", "pose", "twist"});
  const auto with_covariance = odometry.require("pose", "pose and covariance");
  if (!with_covariance || !with_covariance->expect_object()) return std::nullopt;
  with_covariance->expect_members({"pose", "covariance"});
  const auto pose = with_covariance->require("pose", "position and orientation");
  if (!pose || !pose->expect_object()) return std::nullopt;
  pose->expect_members({"position", "orientation"});
  const auto position_field = pose->require("position", "x, y, z");
  const auto orientation_field = pose->require("orientation", "x, y, z, w");
  if (!position_field || !orientation_field) return std::nullopt;
  const auto position = read_numbers<3>(*position_field, {"x", "y", "z"});
  const auto orientation = read_numbers<4>(*orientation_field, {"x", "y", "z", "w"});
  if (!position || !orientation) return std::nullopt;
  const auto [x, y, z, w] = *orientation;
  constexpr double kMaxNormError = 0.1;
  if (!(std::abs(std::hypot(std::hypot(x, y), std::hypot(z, w)) - 1.0) <= kMaxNormError)) {
    orientation_field->fail("must be a unit quaternion");
    return std::nullopt;
  }
  const double yaw = std::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z);
  if (std::abs((*position)[0]) > kMaxCoordinate || std::abs((*position)[1]) > kMaxCoordinate) {
    position_field->fail("must be within 1e8 m");
    return std::nullopt;
  }
  return Pose2{(*position)[0], (*position)[1], yaw};
}

}  // namespace cornerfix::api

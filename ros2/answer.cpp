#include "ros2/answer.hpp"

#include <nlohmann/json.hpp>

namespace cornerfix::ros2 {

namespace {

std::string text_or_empty(const nlohmann::json& json, const char* key) {
  const auto& member = json.at(key);
  return member.is_null() ? std::string() : member.get<std::string>();
}

LocalizedPose parse_pose(const nlohmann::json& json) {
  return {.map = json.at("map"),
          .stamp = json.at("stamp"),
          .T_map_base_link = {json.at("x"), json.at("y"), json.at("yaw")},
          .covariance = json.at("covariance"),
          .epoch = json.at("epoch"),
          .is_confirmed = json.at("confirmed")};
}

}  // namespace

std::optional<Answer> parse_answer(const nlohmann::json& json) {
  try {
    Answer answer{.session = text_or_empty(json, "session"),
                  .status = json.at("status"),
                  .reason = text_or_empty(json, "reason"),
                  .confidence = json.at("confidence"),
                  .pose = std::nullopt};
    if (answer.status == "localized") answer.pose = parse_pose(json.at("pose"));
    return answer;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace cornerfix::ros2

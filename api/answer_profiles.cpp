#include "api/answer_profiles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace cornerfix::api {
namespace {

constexpr std::array<std::pair<AnswerProfile, std::string_view>, 2> kProfileNames{{
    {AnswerProfile::kRos, "ros"},
    {AnswerProfile::kVda5050, "vda5050"},
}};

// --- ROS

/// geometry_msgs/Pose
Json ros_pose(const Json& pose) {
  const double yaw = pose["yaw"];
  return {{"position", {{"x", pose["x"]}, {"y", pose["y"]}, {"z", 0.0}}},
          {"orientation",
           {{"x", 0.0}, {"y", 0.0}, {"z", std::sin(0.5 * yaw)}, {"w", std::cos(0.5 * yaw)}}}};
}

/// builtin_interfaces/Time
Json ros_time(double stamp) {
  constexpr double kNanoseconds = 1e9;
  double seconds = std::floor(stamp);
  double nanoseconds = std::round((stamp - seconds) * kNanoseconds);
  if (nanoseconds >= kNanoseconds) {
    seconds += 1.0;
    nanoseconds = 0.0;
  }
  return {{"sec", static_cast<std::int64_t>(seconds)},
          {"nanosec", static_cast<std::uint32_t>(nanoseconds)}};
}

/// 3 x 3 of x, y, yaw in the 6 x 6 of x, y, z and the rotations about x, y, z.
Json ros_covariance(const Json& covariance) {
  constexpr std::array<std::size_t, 3> kPlace{0, 1, 5};
  Json::array_t entries(36, 0.0);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      entries[6 * kPlace[row] + kPlace[column]] = covariance[3 * row + column];
  }
  return entries;
}

/// geometry_msgs/PoseWithCovarianceStamped
Json ros_stamped_pose(const Json& pose) {
  return {{"header", {{"stamp", ros_time(pose["stamp"])}, {"frame_id", "map"}}},
          {"pose", {{"pose", ros_pose(pose)}, {"covariance", ros_covariance(pose["covariance"])}}}};
}

/// The members of a pose or hypothesis that ROS has no place for.
Json without_pose(Json object) {
  for (const char* name : {"x", "y", "yaw", "stamp", "covariance"}) object.erase(name);
  return object;
}

Json ros_answer(Json answer) {
  const Json pose = answer["pose"];
  answer["pose"] = pose.is_null() ? Json(nullptr) : ros_stamped_pose(pose);
  answer["localized"] = pose.is_null() ? Json(nullptr) : without_pose(pose);
  for (Json& hypothesis : answer["hypotheses"]) {
    Json shaped = without_pose(hypothesis);
    shaped["pose"] = ros_pose(hypothesis);
    hypothesis = std::move(shaped);
  }
  answer["local"]["pose"] = ros_pose(Json(answer["local"]["pose"]));
  return answer;
}

// --- VDA 5050

/// Greatest standard deviation of the position [m].
double deviation_m(const Json& covariance) {
  const auto entry = [&](std::size_t i) {
    return covariance[i].is_number() ? covariance[i].get<double>() : 0.0;
  };
  const double xx = entry(0);
  const double xy = entry(1);
  const double yy = entry(4);
  return std::sqrt(0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy));
}

Json vda_position(const Json& answer, bool is_stale) {
  const Json& pose = answer["pose"];
  return {{"x", pose["x"]},
          {"y", pose["y"]},
          {"theta", pose["yaw"]},
          {"mapId", pose["map"]},
          {"localized", !is_stale},
          {"positionInitialized", !is_stale},
          {"localizationScore", answer["confidence"]},
          {"deviationRange", deviation_m(pose["covariance"])}};
}

/// The map of the pose, as the robot's state lists its maps.
Json vda_map(const Json& pose) {
  return {{"mapId", pose["map"]},
          {"mapVersion", std::to_string(pose["revision"].get<std::uint64_t>())},
          {"mapStatus", "ENABLED"}};
}

Json vda_error(const std::string& status, const Json& reason, bool is_stale) {
  std::string description =
      is_stale ? "The robot has not sent scans for long." : "The robot is " + status + ".";
  Json references = Json::array();
  references.push_back({{"referenceKey", "status"}, {"referenceValue", status}});
  if (!reason.is_null())
    references.push_back({{"referenceKey", "reason"}, {"referenceValue", reason}});
  return {{"errorType", "LOCALIZATION_ERROR"},
          {"errorLevel", status == "lost" || is_stale ? "CRITICAL" : "WARNING"},
          {"errorDescription", std::move(description)},
          {"errorReferences", std::move(references)}};
}

/// `answer` is null before the first one.
Json vda_state(const Json& answer, const std::string& status, bool is_stale) {
  Json state;
  const bool has_pose = !answer.is_null() && !answer["pose"].is_null();
  state["maps"] = Json::array();
  if (has_pose) {
    state["agvPosition"] = vda_position(answer, is_stale);
    state["maps"].push_back(vda_map(answer["pose"]));
  }
  state["errors"] = Json::array();
  if (!has_pose || is_stale) {
    const Json reason = answer.is_null() ? Json(nullptr) : answer["reason"];
    state["errors"].push_back(vda_error(status, reason, is_stale));
  }
  return state;
}

}  // namespace

std::optional<AnswerProfile> answer_profile_from_string(std::string_view name) {
  for (const auto& [profile, known] : kProfileNames) {
    if (known == name) return profile;
  }
  return std::nullopt;
}

std::string_view to_string(AnswerProfile profile) {
  for (const auto& [known, name] : kProfileNames) {
    if (known == profile) return name;
  }
  return "";
}

Json in_profile(Json answer, AnswerProfile profile) {
  if (profile == AnswerProfile::kRos) return ros_answer(std::move(answer));
  if (profile == AnswerProfile::kVda5050) return vda_state(answer, answer["status"], false);
  return answer;
}

Json session_in_profile(Json session, AnswerProfile profile) {
  Json& answer = session["last_answer"];
  if (profile == AnswerProfile::kRos && !answer.is_null()) answer = ros_answer(std::move(answer));
  if (profile == AnswerProfile::kVda5050)
    return vda_state(answer, session["status"], session["stale"]);
  return session;
}

}  // namespace cornerfix::api

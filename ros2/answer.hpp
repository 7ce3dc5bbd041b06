/// \file  What the server answers to a batch of scans.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include <cornerfix/pose2.hpp>

namespace cornerfix::ros2 {

struct LocalizedPose {
  std::string map;
  double stamp = 0.0;  ///< Of the batch's last scan [s].
  Pose2 T_map_base_link;
  std::array<double, 9> covariance{};  ///< x, y, yaw; row by row.
  std::uint64_t epoch = 0;             ///< Rises when the pose is not continuous with those before.
  bool is_confirmed = false;
};

struct Answer {
  std::string session;
  std::string status;  ///< "collecting", "ambiguous", "localized" or "lost".
  std::string reason;  ///< Empty for none.
  double confidence = 0.0;
  std::optional<LocalizedPose> pose;  ///< Only when `status` is "localized".
};

/// Nothing when it is not the answer of a Cornerfix server.
[[nodiscard]] std::optional<Answer> parse_answer(const nlohmann::json& json);

}  // namespace cornerfix::ros2

/// \file  What parsed requests hold, and a session of two lidars.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <variant>

#include "api/requests.hpp"
#include "unit/api/scan_text.hpp"

namespace cornerfix::api {

/// The request, or a failed test that prints the problem.
template <typename Request>
[[nodiscard]] Request taken(Parsed<Request> parsed) {
  if (const auto* problem = std::get_if<Problem>(&parsed)) {
    ADD_FAILURE() << render(*problem);
    return {};
  }
  return std::get<Request>(std::move(parsed));
}

[[nodiscard]] inline std::string lidars_text() {
  return std::string(R"({"front": )") + kLidarText + R"(, "rear": {
      "angle_min": 0, "angle_increment": 0.1, "range_min": 0, "range_max": 5,
      "mount": {"x": -0.2, "y": 0, "yaw": 3, "roll": 3.1415926, "pitch": 0.1}}})";
}

[[nodiscard]] inline Parsed<CreateSessionRequest> session_with_lidars(const std::string& lidars) {
  return parse_create_session(R"({"robot": "r2", "lidars": )" + lidars + "}", BodyFormat::kJson);
}

}  // namespace cornerfix::api

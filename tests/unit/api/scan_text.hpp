/// \file  Request texts for the tests of this module.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "api/requests.hpp"

namespace cornerfix::api {

inline const char* const kLidarText =
    R"({"angle_min": -1.0, "angle_increment": 0.5, "range_min": 0.1, "range_max": 10.0})";

inline Lidar three_beam_lidar() {
  return {.angle_min = -1.0,
          .angle_increment = 0.5,
          .range_min = 0.1,
          .range_max = 10.0,
          .beams = 3,
          .T_base_link_laser = {}};
}

/// A batch of a session around the text of its scans.
inline std::string session_batch(const std::string& scans) {
  return R"({"sequence": 0, "scans": [)" + scans + "]}";
}

/// The same document in another format.
inline std::string encode_as(const nlohmann::json& document, BodyFormat format) {
  std::vector<std::uint8_t> bytes;
  if (format == BodyFormat::kJson) return document.dump();
  bytes = format == BodyFormat::kCbor ? nlohmann::json::to_cbor(document)
                                      : nlohmann::json::to_msgpack(document);
  return {bytes.begin(), bytes.end()};
}

}  // namespace cornerfix::api

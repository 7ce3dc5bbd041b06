/// \file  Request bodies, parsed and validated whole before anything is done with them.
///
/// Bodies are JSON (scans by simdjson), CBOR or MessagePack by content type. A parse gives a
/// request that is valid in every field, or a Problem with a pointer to each wrong one (at most
/// 20). Limits are checked while parsing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/localizer_params.hpp>
#include <cornerfix/mapper.hpp>

#include "api/problem.hpp"

namespace cornerfix::api {

struct RequestLimits {
  std::size_t max_scans = 100;     ///< A batch.
  std::size_t max_beams = 20'000;  ///< A scan.
};

enum class BodyFormat { kJson, kCbor, kMessagePack };

/// `lidar` of the contract. `beams` from the first scan when not given.
struct Lidar {
  double angle_min = 0.0;
  double angle_increment = 0.0;
  double range_min = 0.0;
  double range_max = 0.0;
  std::optional<std::size_t> beams;
  Pose2 T_base_link_laser;
};

struct PutMapRequest {
  std::optional<std::string> description;
  std::optional<std::string> lidar_json;       ///< Normalised text of the validated member.
  std::optional<std::string> parameters_json;  ///< Normalised text of the validated member.
};
struct MapScansRequest {
  std::optional<Lidar> lidar;
  std::vector<PosedScan> scans;
};
struct StampedPose {
  double stamp = 0.0;
  Pose2 T_map_base_link;
};
struct TrajectoryRequest {
  std::vector<StampedPose> poses;
};
struct CreateSessionRequest {
  std::string robot;
  std::vector<std::string> maps;  ///< Empty: every map.
  Lidar lidar;
  std::string lidar_json, options_json;
  LocalizerParams params;  ///< Defaults with `options` applied.
};
struct SessionScansRequest {
  std::uint64_t sequence = 0;
  std::vector<RobotScan> scans;
};
struct LocalizeRequest {
  Lidar lidar;
  std::vector<RobotScan> scans;
  LocalizerParams params;
};

template <typename T>
using Parsed = std::variant<T, Problem>;

[[nodiscard]] Parsed<PutMapRequest> parse_put_map(std::string_view body, BodyFormat format);
/// `lidar` is the map's, used where the body has none; beams are checked against it.
[[nodiscard]] Parsed<MapScansRequest> parse_map_scans(std::string_view body, BodyFormat format,
                                                      const std::optional<Lidar>& lidar,
                                                      const RequestLimits& limits);
[[nodiscard]] Parsed<TrajectoryRequest> parse_trajectory(std::string_view body, BodyFormat format);
[[nodiscard]] Parsed<CreateSessionRequest> parse_create_session(std::string_view body,
                                                                BodyFormat format);
[[nodiscard]] Parsed<SessionScansRequest> parse_session_scans(std::string_view body,
                                                              BodyFormat format, const Lidar& lidar,
                                                              const RequestLimits& limits);
[[nodiscard]] Parsed<LocalizeRequest> parse_localize(std::string_view body, BodyFormat format,
                                                     const RequestLimits& limits);

/// From what the store kept; the texts were made by a parse above, so they are valid.
[[nodiscard]] std::optional<Lidar> lidar_from_json(std::string_view lidar_json);
[[nodiscard]] LocalizerParams params_from_json(std::string_view options_json);
[[nodiscard]] MapperParams mapper_params_from_json(std::string_view parameters_json);

/// [A-Za-z0-9][A-Za-z0-9._-]{0,127}
[[nodiscard]] bool is_valid_name(std::string_view name);

}  // namespace cornerfix::api

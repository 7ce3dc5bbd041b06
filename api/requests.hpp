/// \file  Request bodies, parsed and validated whole before anything is done with them.
///
/// Bodies are JSON (scans by simdjson), CBOR or MessagePack by content type; binary_batch.hpp has
/// one more for batches of sessions. A parse gives a request that is valid in every field, or a
/// Problem with a pointer to each wrong one (at most 20). Limits are checked while parsing. Unknown
/// members are wrong, but those of ROS messages that are not used. A member that is there twice
/// makes a body malformed.
#pragma once

#include <cstdint>
#include <map>
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

enum class BodyFormat {
  kJson,
  kCbor,
  kMessagePack,
  kBinaryBatch,  ///< Of a batch of a session only, see binary_batch.hpp; never of an answer.
};

/// `lidar` of the contract.
struct Lidar {
  double angle_min = 0.0;
  double angle_increment = 0.0;
  double range_min = 0.0;
  double range_max = 0.0;
  /// Ranges of a scan without angles of its own; any number when not given.
  std::optional<std::size_t> beams;
  Pose2 T_base_link_laser;
  double time_increment = 0.0;  ///< From beam to beam [s]; 0 when scans are taken at once.
  LidarTilt tilt{};             ///< Scans are levelled when they are read.
  friend bool operator==(const Lidar&, const Lidar&) = default;
};

/// The lidars of a session: one; several, and each scan names one; or none, and each scan brings
/// its own geometry.
struct Lidars {
  Lidars() = default;
  Lidars(std::optional<Lidar> lidar) : only(lidar) {}
  Lidars(const Lidar& lidar) : only(lidar) {}

  std::optional<Lidar> only;
  std::map<std::string, Lidar, std::less<>> by_name;  ///< Empty beside `only`.
  friend bool operator==(const Lidars&, const Lidars&) = default;
};

struct PutMapRequest {
  std::optional<std::string> description;
  std::optional<Lidar> lidar;
  /// The parameters that were given, as the text that is stored: a map's digest is made of it.
  std::optional<std::string> parameters_json;
};
struct MapScansRequest {
  /// The body's, or else the map's. Nothing when each scan brings its own.
  std::optional<Lidar> lidar;
  std::vector<PosedScan> scans;
  /// Instead of `scans` where none has a pose; stamps strictly increase.
  std::vector<RobotScan> unposed_scans;
};
struct StampedPose {
  double stamp = 0.0;
  Pose2 T_map_base_link;
};
struct TrajectoryRequest {
  std::vector<StampedPose> poses;  ///< At least one, as given, in any order.
};
struct RollBackRequest {
  std::uint64_t revision = 0;
};
struct CreateSessionRequest {
  std::string robot;
  std::vector<std::string> maps;  ///< Empty: every map.
  Lidars lidars;
  std::string options_json;  ///< The options that were given, as the text that is stored.
  LocalizerParams params;    ///< Defaults with them applied.
  std::optional<StartRegion> region;
};
struct ResetRequest {
  std::optional<StartRegion> region;
};
struct SessionScansRequest {
  std::uint64_t sequence = 0;
  /// At least one. Stamps of one lidar strictly increase, those of several do not decrease.
  std::vector<RobotScan> scans;
};
struct LocalizeRequest {
  std::vector<RobotScan> scans;  ///< At least one, stamps strictly increase.
  LocalizerParams params;
};

template <typename T>
using Parsed = std::variant<T, Problem>;

[[nodiscard]] Parsed<PutMapRequest> parse_put_map(std::string_view body, BodyFormat format);
/// `lidar` is the map's, used where the body has none. A body that repeats it without `beams` means
/// the same lidar, so the map's number of beams holds.
[[nodiscard]] Parsed<MapScansRequest> parse_map_scans(std::string_view body, BodyFormat format,
                                                      const std::optional<Lidar>& lidar,
                                                      const RequestLimits& limits);
[[nodiscard]] Parsed<TrajectoryRequest> parse_trajectory(std::string_view body, BodyFormat format);
[[nodiscard]] Parsed<RollBackRequest> parse_roll_back(std::string_view body, BodyFormat format);
[[nodiscard]] Parsed<CreateSessionRequest> parse_create_session(std::string_view body,
                                                                BodyFormat format);
[[nodiscard]] Parsed<ResetRequest> parse_reset(std::string_view body, BodyFormat format);
[[nodiscard]] Parsed<SessionScansRequest> parse_session_scans(std::string_view body,
                                                              BodyFormat format,
                                                              const Lidars& lidars,
                                                              const RequestLimits& limits);
[[nodiscard]] Parsed<LocalizeRequest> parse_localize(std::string_view body, BodyFormat format,
                                                     const RequestLimits& limits);

[[nodiscard]] std::string lidar_to_json(const Lidar& lidar);
/// Empty for none.
[[nodiscard]] std::string lidars_to_json(const Lidars& lidars);

/// From what the store kept; the texts were made by a parse above, so they are valid. An empty text
/// gives nothing, or the defaults.
[[nodiscard]] std::optional<Lidar> lidar_from_json(std::string_view lidar_json);
/// Nothing when the text was not made by lidars_to_json().
[[nodiscard]] std::optional<Lidars> lidars_from_json(std::string_view lidars_json);
[[nodiscard]] LocalizerParams params_from_json(std::string_view options_json);
[[nodiscard]] MapperParams mapper_params_from_json(std::string_view parameters_json);

/// A map's parameters after `given`, the text of a parse above, was put: those that it leaves out
/// stay as `stored` has them. kInvalidArgument when they do not go together.
[[nodiscard]] Result<std::string> merged_parameters(std::string_view stored,
                                                    std::string_view given);

/// Whether a parse_put_map() could have given all three, empty ones aside: to be asked of what was
/// stored by somebody else.
[[nodiscard]] bool is_put_map_request(std::string_view description, std::string_view lidar_json,
                                      std::string_view parameters_json);

/// `bbox` of a query: "x0,y0,x1,y1" in `map` [m], any two opposite corners.
[[nodiscard]] Parsed<Bounds> parse_bbox(std::string_view text);
/// `limit` of a query: 1 to 1000.
[[nodiscard]] Parsed<std::size_t> parse_page_limit(std::string_view text);
/// `page_token` of a query for sessions or jobs, as the page before gave it.
[[nodiscard]] Parsed<std::size_t> parse_number_page_token(std::string_view text);
/// `wait` of a query: 0 to 60 [s].
[[nodiscard]] Parsed<std::size_t> parse_wait(std::string_view text);

/// [A-Za-z0-9][A-Za-z0-9._-]{0,127}
[[nodiscard]] bool is_valid_name(std::string_view name);

}  // namespace cornerfix::api

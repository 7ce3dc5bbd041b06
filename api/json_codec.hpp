/// \file  Core types as the documents of the wire contract, and documents as bytes.
///
/// No document holds NaN or infinity: a number that is not finite becomes null.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/localizer.hpp>

#include "api/requests.hpp"

namespace cornerfix::api {

using Json = nlohmann::ordered_json;  ///< Members in the order of the documentation.

/// "application/json", "application/cbor" or "application/msgpack".
[[nodiscard]] std::string_view media_type(BodyFormat format);
/// Bytes of a body. Text that is not UTF-8 is replaced, so it never fails.
[[nodiscard]] std::string encode(const Json& document, BodyFormat format);

/// Which batch an answer belongs to.
struct AnswerOrigin {
  std::string_view session;               ///< Empty for a stateless question: null.
  std::optional<std::uint64_t> sequence;  ///< Null for a stateless question.
  double stamp = 0.0;                     ///< Of the batch's last scan [s].
};
[[nodiscard]] Json render_answer(const Answer& answer, const AnswerOrigin& origin);
/// `timing_ms`, to the microsecond.
[[nodiscard]] Json render_times(const StepTimes& times);
/// The answer with `scan_points` and `feature_points` for the inspector, both in `base_link` [m],
/// rounded to millimetres.
[[nodiscard]] Json with_points(Json answer, const RobotScan& last_scan,
                               std::span<const Point2> features_base_link);

/// `lidar` of the contract, as it is stored, too.
[[nodiscard]] Json render_lidar(const Lidar& lidar);

/// A map without its content.
struct MapEntry {
  std::string_view name;
  std::string_view description;
  std::uint64_t revision = 0;
  std::string_view digest;
  bool has_floor_map = false;  ///< Made from an occupancy map, not from scans.
  std::size_t key_frames = 0;
  std::size_t features = 0;
  std::optional<Bounds> bounds;
  std::string_view created;  ///< RFC 3339.
  std::string_view updated;
  std::optional<Lidar> lidar;
  MapperParams parameters;
};
/// `parameters` are all that are in force, defaults too.
[[nodiscard]] Json render_map(const MapEntry& map);
/// `next_page_token` is null on the last page.
[[nodiscard]] Json render_map_list(std::span<const MapEntry> maps,
                                   std::optional<std::string_view> next_page_token);

/// What an occupancy map became.
struct FloorMapResult {
  std::uint64_t revision = 0;
  std::string_view digest;
  std::size_t features = 0;
  std::span<const std::string> warnings;
};
[[nodiscard]] Json render_floor_map(const FloorMapResult& result);

/// What a mapping batch did.
struct MapBatchResult {
  std::size_t accepted = 0;
  std::size_t duplicates = 0;
  std::size_t key_frames = 0;  ///< Of the map, now.
  std::size_t features = 0;    ///< Of the map, now.
  std::uint64_t revision = 0;
};
[[nodiscard]] Json render_map_batch(const MapBatchResult& result);

/// Features within `box`, or all. Ids are positions in `features`, stable within a revision.
[[nodiscard]] Json render_features(std::uint64_t revision, std::span<const Feature> features,
                                   const std::optional<Bounds>& box);
[[nodiscard]] Json render_descriptor(std::uint64_t revision, std::size_t feature,
                                     const DescriptorParams& params,
                                     std::span<const DescriptorEntry> descriptor);

/// A robot's session.
struct SessionEntry {
  std::string_view id;
  std::string_view robot;
  std::span<const std::string> maps;  ///< As asked for; empty: every map.
  std::string_view created;           ///< RFC 3339.
  std::string_view last_seen;         ///< When it took its last batch, was reset or created.
  bool is_stale = false;              ///< Not seen for long.
  std::string_view superseded_by;     ///< Id of a newer session of the robot; empty: none.
  std::uint64_t expected = 0;         ///< Sequence of the next batch.
  Status status = Status::kCollecting;
  Lidars lidars;
  LocalizerParams params;
  std::optional<StartRegion> region;  ///< While it restricts the search.
  const Json* last_answer = nullptr;  ///< Null before the first batch, also after a reset.
  bool is_damaged = false;            ///< What is stored of its state cannot be read.
};
/// `options` are all that are in force, defaults too.
[[nodiscard]] Json render_session(const SessionEntry& session);

}  // namespace cornerfix::api

#include "api/json_codec.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/params_codec.hpp"
#include "api/start_region_codec.hpp"

namespace cornerfix::api {
namespace {

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json pose_json(const Pose2& pose) {
  return {{"x", number(pose.x)}, {"y", number(pose.y)}, {"yaw", number(pose.yaw)}};
}

Json localized_pose_json(const LocalizedPose& pose, double stamp) {
  Json json = {
      {"map", pose.map->name()}, {"revision", pose.map->revision()}, {"stamp", number(stamp)}};
  json.update(pose_json(pose.T_map_base_link));
  json["covariance"] = Json::array();
  for (const double entry : pose.covariance) json["covariance"].push_back(number(entry));
  json["epoch"] = pose.epoch;
  json["confirmed"] = pose.confirmed;
  return json;
}

Json hypothesis_json(const RankedHypothesis& hypothesis) {
  Json json = {{"map", hypothesis.map->name()}, {"revision", hypothesis.map->revision()}};
  json.update(pose_json(hypothesis.T_map_base_link));
  json["votes"] = hypothesis.votes;
  json["inliers"] = hypothesis.inliers;
  json["score"] = number(hypothesis.score);
  return json;
}

/// Millimetres of metres, microseconds of milliseconds: more digits have no meaning.
Json to_thousandths(double value) { return number(std::round(value * 1e3) / 1e3); }

/// What the probability of the best candidate pose is made of; null before there is one.
Json explanation_json(const Answer& answer) {
  if (answer.hypotheses.empty()) return nullptr;
  return {{"explained_share", to_thousandths(answer.terms.explained_share)},
          {"unknown_share", to_thousandths(answer.terms.unknown_share)},
          {"margin_per_hit", to_thousandths(answer.terms.margin_per_hit)},
          {"probability_explained", to_thousandths(answer.terms.probability_explained)},
          {"probability_best", to_thousandths(answer.terms.probability_best)}};
}

Json point_json(const Point2& point) {
  return Json::array({to_thousandths(point.x()), to_thousandths(point.y())});
}

Json bounds_json(const std::optional<Bounds>& bounds) {
  if (!bounds) return nullptr;
  return {{"min_x", number(bounds->min.x())},
          {"min_y", number(bounds->min.y())},
          {"max_x", number(bounds->max.x())},
          {"max_y", number(bounds->max.y())}};
}

bool contains(const Bounds& box, const Point2& point) {
  return (point.array() >= box.min.array()).all() && (point.array() <= box.max.array()).all();
}

Json feature_json(std::size_t id, const Feature& feature) {
  return {{"id", id},
          {"x", number(feature.position.x())},
          {"y", number(feature.position.y())},
          {"angle", number(feature.turn_angle)},
          {"weight", number(feature.weight)},
          {"bisector", number(feature.bisector)},
          {"convex", feature.convex},
          {"sigma", feature.sigma_m > 0.0 ? number(feature.sigma_m) : Json(nullptr)},
          {"count", feature.count}};
}

Json lidars_by_name(const Lidars& lidars) {
  if (lidars.by_name.empty()) return nullptr;
  Json json;
  for (const auto& [name, lidar] : lidars.by_name) json[name] = render_lidar(lidar);
  return json;
}

std::string as_string(const std::vector<std::uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::string_view media_type(BodyFormat format) {
  switch (format) {
    case BodyFormat::kCbor:
      return "application/cbor";
    case BodyFormat::kMessagePack:
      return "application/msgpack";
    case BodyFormat::kJson:
    case BodyFormat::kBinaryBatch:
      break;
  }
  return "application/json";
}

std::string encode(const Json& document, BodyFormat format) {
  switch (format) {
    case BodyFormat::kCbor:
      return as_string(Json::to_cbor(document));
    case BodyFormat::kMessagePack:
      return as_string(Json::to_msgpack(document));
    case BodyFormat::kJson:
    case BodyFormat::kBinaryBatch:
      break;
  }
  return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json render_times(const StepTimes& times) {
  return {{"odometry", to_thousandths(times.odometry_ms)},
          {"extract", to_thousandths(times.extract_ms)},
          {"match", to_thousandths(times.match_ms)},
          {"verify", to_thousandths(times.verify_ms)},
          {"track", to_thousandths(times.track_ms)},
          {"total", to_thousandths(times.total_ms)}};
}

Json render_answer(const Answer& answer, const AnswerOrigin& origin) {
  Json json;
  json["session"] = origin.session.empty() ? Json(nullptr) : Json(origin.session);
  json["sequence"] = origin.sequence ? Json(*origin.sequence) : Json(nullptr);
  json["status"] = to_string(answer.status);
  const bool has_pose = answer.status == Status::kLocalized && answer.pose.has_value();
  json["pose"] = has_pose ? localized_pose_json(*answer.pose, origin.stamp) : Json(nullptr);
  json["confidence"] = number(answer.confidence);
  json["hypotheses"] = Json::array();
  for (const RankedHypothesis& hypothesis : answer.hypotheses) {
    json["hypotheses"].push_back(hypothesis_json(hypothesis));
  }
  json["given"] = answer.is_given_region ? Json("near") : Json(nullptr);
  json["explanation"] = explanation_json(answer);
  json["reason"] = answer.reason == Reason::kNone ? Json(nullptr) : Json(to_string(answer.reason));
  json["odometry"] =
      answer.odometry == OdometryUse::kNone ? Json(nullptr) : Json(to_string(answer.odometry));
  json["local"] = {{"scans", answer.local_scans},
                   {"features", answer.local_features},
                   {"pose", pose_json(answer.T_submap_base_link)}};
  if (answer.searched_maps > 1) json["searched_maps"] = answer.searched_maps;
  json["timing_ms"] = render_times(answer.times);
  return json;
}

Json with_points(Json answer, const RobotScan& last_scan,
                 std::span<const Point2> features_base_link) {
  Json& scan_points = answer["scan_points"] = Json::array();
  for (const Point2& point_laser : returns_as_points(last_scan.scan)) {
    scan_points.push_back(point_json(last_scan.T_base_link_laser * point_laser));
  }
  Json& feature_points = answer["feature_points"] = Json::array();
  for (const Point2& point : features_base_link) feature_points.push_back(point_json(point));
  return answer;
}

Json render_lidar(const Lidar& lidar) {
  Json json = {{"angle_min", lidar.angle_min},
               {"angle_increment", lidar.angle_increment},
               {"range_min", lidar.range_min},
               {"range_max", nullptr}};  // JSON has no infinity.
  if (std::isfinite(lidar.range_max)) json["range_max"] = lidar.range_max;
  if (lidar.beams) json["beams"] = *lidar.beams;
  if (lidar.time_increment != 0.0) json["time_increment"] = lidar.time_increment;
  const Pose2& mount = lidar.T_base_link_laser;
  json["mount"] = {{"x", mount.x}, {"y", mount.y}, {"yaw", mount.yaw}};
  if (lidar.tilt.roll != 0.0) json["mount"]["roll"] = lidar.tilt.roll;
  if (lidar.tilt.pitch != 0.0) json["mount"]["pitch"] = lidar.tilt.pitch;
  return json;
}

Json render_map(const MapEntry& map) {
  return {{"name", map.name},
          {"description", map.description},
          {"revision", map.revision},
          {"digest", map.digest},
          {"floor_map", map.has_floor_map},
          {"keyframes", map.key_frames},
          {"features", map.features},
          {"bounds", bounds_json(map.bounds)},
          {"created", map.created},
          {"updated", map.updated},
          {"lidar", map.lidar ? render_lidar(*map.lidar) : Json(nullptr)},
          {"parameters", params_to_json(map.parameters)}};
}

Json render_map_list(std::span<const MapEntry> maps,
                     std::optional<std::string_view> next_page_token) {
  Json list = Json::array();
  for (const MapEntry& map : maps) list.push_back(render_map(map));
  return {{"maps", std::move(list)},
          {"next_page_token", next_page_token ? Json(*next_page_token) : Json(nullptr)}};
}

Json render_floor_map(const FloorMapResult& result) {
  return {{"revision", result.revision},
          {"digest", result.digest},
          {"features", result.features},
          {"warnings", std::vector<std::string>(result.warnings.begin(), result.warnings.end())}};
}

Json render_map_batch(const MapBatchResult& result) {
  return {{"accepted", result.accepted},
          {"duplicates", result.duplicates},
          {"keyframes", result.key_frames},
          {"features", result.features},
          {"revision", result.revision}};
}

Json render_features(std::uint64_t revision, std::span<const Feature> features,
                     const std::optional<Bounds>& box) {
  Json list = Json::array();
  for (std::size_t id = 0; id < features.size(); ++id) {
    if (box && !contains(*box, features[id].position)) continue;
    list.push_back(feature_json(id, features[id]));
  }
  return {{"revision", revision}, {"features", std::move(list)}};
}

Json render_descriptor(std::uint64_t revision, std::size_t feature, const DescriptorParams& params,
                       std::span<const DescriptorEntry> descriptor) {
  Json entries = Json::array();
  for (const DescriptorEntry& entry : descriptor) {
    entries.push_back({{"feature", entry.feature},
                       {"distance_bin", entry.distance_bin},
                       {"angle_bin", entry.angle_bin}});
  }
  return {{"revision", revision},
          {"feature", feature},
          {"distance_resolution_m", params.distance_resolution_m},
          {"angle_resolution_rad", params.angle_resolution_rad},
          {"angle_bins", angle_bins(params)},
          {"entries", std::move(entries)}};
}

Json render_session(const SessionEntry& session) {
  const bool one_map = session.maps.size() == 1;
  Json json = {{"id", session.id}, {"robot", session.robot}};
  json["map"] = one_map ? Json(session.maps.front()) : Json(nullptr);
  json["maps"] = session.maps.empty() ? Json(nullptr) : Json(session.maps);
  const std::optional<Lidar>& lidar = session.lidars.only;
  json["lidar"] = lidar ? render_lidar(*lidar) : Json(nullptr);
  json["lidars"] = lidars_by_name(session.lidars);
  json["options"] = params_to_json(session.params);
  json["near"] = render_start_region(session.region);
  json["created"] = session.created;
  json["last_seen"] = session.last_seen;
  json["stale"] = session.is_stale;
  if (session.is_damaged) json["damaged"] = true;
  json["superseded_by"] =
      session.superseded_by.empty() ? Json(nullptr) : Json(session.superseded_by);
  json["expected"] = session.expected;
  json["status"] = to_string(session.status);
  json["last_answer"] = session.last_answer != nullptr ? *session.last_answer : Json(nullptr);
  return json;
}

}  // namespace cornerfix::api

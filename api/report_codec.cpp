#include "api/report_codec.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include <cornerfix/localizability.hpp>

#include "api/report_advice.hpp"

namespace cornerfix::api {
namespace {

constexpr std::size_t kMinToMatch = 4;  // The paper's methods try no match with less.

/// Thousandths: millimetres, milliradians.
Json rounded(double value) { return std::round(value * 1e3) / 1e3; }

Json point_json(const Point2& point) {
  return {{"x", rounded(point.x())}, {"y", rounded(point.y())}};
}

Json point_json(const std::optional<Point2>& point) {
  return point ? point_json(*point) : Json(nullptr);
}

Json pose_json(const Pose2& pose) {
  return {{"x", rounded(pose.x)}, {"y", rounded(pose.y)}, {"yaw", rounded(pose.yaw)}};
}

Json robot_json(const SimulatedRobot& robot) {
  return {{"angle_min", robot.lidar.angle_min},
          {"angle_increment", robot.lidar.angle_increment},
          {"range_min", robot.lidar.range_min},
          {"range_max", robot.lidar.range_max},
          {"beams", robot.beams},
          {"mount", pose_json(robot.T_base_link_laser)}};
}

Json start_json(const AssessedStart& start) {
  return {{"yaw", rounded(start.T_map_base_link.yaw)},
          {"way_m", start.way_m ? rounded(*start.way_m) : Json(nullptr)},
          {"confidence", rounded(start.confidence)}};
}

Json place_json(const AssessedPlace& place, double way_limit_m) {
  Json json = point_json(place.position_map);
  json["way_m"] = rounded(expected_way_m(place, way_limit_m));
  json["found"] = rounded(
      static_cast<double>(std::ranges::count_if(
          place.starts, [](const AssessedStart& start) { return start.way_m.has_value(); })) /
      static_cast<double>(place.starts.size()));
  json["features_near"] = place.features_near;
  json["few_features"] = place.features_near < kMinToMatch;
  json["starts"] = Json::array();
  for (const AssessedStart& start : place.starts) json["starts"].push_back(start_json(start));
  return json;
}

Json area_json(const LowLocalizabilityRegion& area) {
  Json json = point_json(area.center_map);
  json["radius_m"] = rounded(area.radius_m);
  json["places"] = area.places.size();
  json["way_m"] = rounded(area.way_m);
  json["found"] = rounded(area.found);
  json["looks_like"] = point_json(area.look_alike_map);
  json["better_start"] = point_json(area.easy_map);
  return json;
}

Json look_alike_json(const AliasedPoses& pair) {
  return {{"a", pose_json(pair.T_map_a)},
          {"b", pose_json(pair.T_map_b)},
          {"way_m", rounded(pair.way_m)},
          {"starts", pair.starts}};
}

/// Of all starts; those that were not localized count with the whole limit.
double way_percentile(const LocalizabilityReport& report, double share) {
  std::vector<double> ways;
  for (const AssessedPlace& place : report.places) {
    for (const AssessedStart& start : place.starts)
      ways.push_back(start.way_m.value_or(report.way_limit_m));
  }
  if (ways.empty()) return report.way_limit_m;
  const auto index = static_cast<std::size_t>(share * static_cast<double>(ways.size()));
  std::ranges::sort(ways);
  return ways[std::min(index, ways.size() - 1)];
}

Json head_of(const ReportOrigin& origin, const char* state, double share) {
  return {{"map", origin.map},
          {"revision", origin.revision},
          {"state", state},
          {"progress", rounded(share)}};
}

}  // namespace

Json render_report_progress(const ReportOrigin& origin, double share) {
  return head_of(origin, "computing", share);
}

Json render_report(const ReportOrigin& origin, const LocalizabilityReport& report) {
  const std::vector<LowLocalizabilityRegion> areas = find_low_localizability_regions(report);
  const ReportShares shares = shares_of(report);
  Json json = head_of(origin, "done", 1.0);
  json["summary"] = summarize(report);
  json["advice"] = advise(report, areas);
  json["lidar"] = robot_json(report.robot);
  json["free_area_m2"] = rounded(report.free_area_m2);
  json["features"] = report.features;
  json["features_per_100_m2"] = rounded(features_per_100_m2(report));
  json["lattice_m"] = rounded(report.lattice_m);
  json["way_limit_m"] = report.way_limit_m;
  json["success"] = rounded(shares.found);
  json["success_at_once"] = rounded(shares.found_at_once);
  json["wrong"] = shares.wrong;
  json["way_m"] = {{"p50", rounded(way_percentile(report, 0.5))},
                   {"p90", rounded(way_percentile(report, 0.9))}};
  for (const char* list : {"areas", "look_alikes", "places"}) json[list] = Json::array();
  for (const LowLocalizabilityRegion& area : areas) json["areas"].push_back(area_json(area));
  for (const AliasedPoses& pair : report.look_alikes)
    json["look_alikes"].push_back(look_alike_json(pair));
  for (const AssessedPlace& place : report.places)
    json["places"].push_back(place_json(place, report.way_limit_m));
  return json;
}

}  // namespace cornerfix::api

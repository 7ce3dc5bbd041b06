#include "clients/cpp/scan_json.hpp"

#include <cmath>

namespace cornerfix::client {

namespace {

/// Tenths of a millimetre: below what any lidar knows, and half the text of a float in full.
double rounded(float range) { return std::round(static_cast<double>(range) * 1e4) / 1e4; }

nlohmann::ordered_json range_json(const LaserScan& scan, std::size_t beam) {
  if (!scan.has_return(beam)) return nullptr;
  return rounded(scan.ranges[beam]);
}

/// JSON has no infinity: a lidar without limit has the range_max null.
nlohmann::ordered_json geometry_json(const LaserScan& lidar) {
  nlohmann::ordered_json json = {{"angle_min", lidar.angle_min},
                                 {"angle_increment", lidar.angle_increment},
                                 {"range_min", lidar.range_min},
                                 {"range_max", nullptr}};
  if (std::isfinite(lidar.range_max)) json["range_max"] = lidar.range_max;
  return json;
}

nlohmann::ordered_json scan_json(const evaluation::LogHeader& header, const LaserScan& scan) {
  auto ranges = nlohmann::ordered_json::array();
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    ranges.push_back(range_json(scan, beam));
  }
  nlohmann::ordered_json json = {{"stamp", scan.stamp}};
  if (!evaluation::has_lidar_of(header, scan)) json.update(geometry_json(scan));
  json["ranges"] = std::move(ranges);
  return json;
}

}  // namespace

nlohmann::ordered_json pose_json(const Pose2& pose) {
  return {{"x", pose.x}, {"y", pose.y}, {"yaw", pose.yaw}};
}

nlohmann::ordered_json lidar_json(const evaluation::LogHeader& header) {
  nlohmann::ordered_json json = geometry_json(header.lidar);
  json["beams"] = header.beams;
  return json;
}

LaserScan as_sent(LaserScan scan) {
  for (float& range : scan.ranges) range = static_cast<float>(rounded(range));
  return scan;
}

std::vector<PosedScan> posed_scans_as_sent(std::span<const evaluation::LogScan> scans) {
  std::vector<PosedScan> posed;
  posed.reserve(scans.size());
  for (const evaluation::LogScan& scan : scans)
    posed.push_back({as_sent(scan.scan), Pose2{}, *scan.T_map_laser});
  return posed;
}

std::vector<RobotScan> robot_scans_as_sent(std::span<const evaluation::LogScan> scans) {
  std::vector<RobotScan> robot;
  robot.reserve(scans.size());
  for (const evaluation::LogScan& scan : scans)
    robot.push_back({as_sent(scan.scan), Pose2{}, scan.T_odom_laser});
  return robot;
}

nlohmann::ordered_json posed_scan_json(const evaluation::LogHeader& header,
                                       const evaluation::LogScan& scan) {
  nlohmann::ordered_json json = scan_json(header, scan.scan);
  json["pose"] = pose_json(*scan.T_map_laser);
  return json;
}

nlohmann::ordered_json robot_scan_json(const evaluation::LogHeader& header,
                                       const evaluation::LogScan& scan, bool with_odometry) {
  nlohmann::ordered_json json = scan_json(header, scan.scan);
  if (with_odometry && scan.T_odom_laser) json["odom"] = pose_json(*scan.T_odom_laser);
  return json;
}

std::optional<Pose2> pose_from_json(const nlohmann::json& json) {
  if (!json.is_object()) return std::nullopt;
  const auto number = [&](const char* key) {
    const auto member = json.find(key);
    return member != json.end() && member->is_number() ? member->get<double>() : NAN;
  };
  const Pose2 pose{number("x"), number("y"), number("yaw")};
  if (std::isnan(pose.x) || std::isnan(pose.y) || std::isnan(pose.yaw)) return std::nullopt;
  return pose;
}

}  // namespace cornerfix::client

// Any bytes are the body of a call in JSON, CBOR, MessagePack or as a binary batch, or a problem
// that says what is wrong. The first byte picks the format and the call. What is accepted keeps the
// promises that the library asserts: finite geometry, stamps that increase, no more than the
// limits.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string_view>
#include <variant>

#include "api/requests.hpp"

namespace {

using namespace cornerfix;

constexpr api::RequestLimits kLimits{.max_scans = 10, .max_beams = 200};
const api::Lidar kLidar{.angle_min = -1.5,
                        .angle_increment = 0.1,
                        .range_min = 0.05,
                        .range_max = 30.0,
                        .beams = 3,
                        .T_base_link_laser = {}};

void require(bool condition) {
  if (!condition) std::abort();
}

bool is_finite(const Pose2& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::abs(pose.yaw) <= M_PI;
}

void check(const LaserScan& scan) {
  require(std::isfinite(scan.stamp) && std::isfinite(scan.angle_min));
  require(std::isfinite(scan.angle_increment) && scan.angle_increment != 0.0);
  require(scan.range_min >= 0.0 && scan.range_max > scan.range_min);
  require(!scan.ranges.empty() && scan.ranges.size() <= kLimits.max_beams);
}

void check(std::span<const RobotScan> scans) {
  require(!scans.empty() && scans.size() <= kLimits.max_scans);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    check(scans[i].scan);
    require(is_finite(scans[i].T_base_link_laser));
    if (scans[i].T_odom_base_link) require(is_finite(*scans[i].T_odom_base_link));
    if (i > 0) require(scans[i].scan.stamp > scans[i - 1].scan.stamp);
  }
}

void check(const api::SessionScansRequest& request) { check(request.scans); }
void check(const api::LocalizeRequest& request) {
  check(request.scans);
  require(!validate(request.params));
}
void check(const api::MapScansRequest& request) {
  for (const PosedScan& posed : request.scans) {
    check(posed.scan);
    require(is_finite(posed.T_map_base_link));
  }
  require(request.scans.empty() != request.unposed_scans.empty());
  if (!request.unposed_scans.empty()) check(request.unposed_scans);
}
void check(const api::TrajectoryRequest& request) {
  require(!request.poses.empty());
  for (const api::StampedPose& pose : request.poses) require(is_finite(pose.T_map_base_link));
}
void check(const api::CreateSessionRequest& request) {
  require(api::is_valid_name(request.robot) && !validate(request.params));
  require(api::lidars_from_json(api::lidars_to_json(request.lidars)) == request.lidars);
}
void check(const api::PutMapRequest& request) {
  if (request.lidar)
    require(api::lidar_from_json(api::lidar_to_json(*request.lidar)) == request.lidar);
  if (request.parameters_json) {
    require(!validate(api::mapper_params_from_json(*request.parameters_json)));
  }
}

template <typename T>
int check_parsed(const api::Parsed<T>& parsed) {
  if (const auto* problem = std::get_if<api::Problem>(&parsed)) {
    require(problem->status == 400 || problem->status == 413 || problem->status == 422);
    require(!problem->detail.empty() && !api::render(*problem).empty());
  } else {
    check(std::get<T>(parsed));
  }
  return 0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view body(reinterpret_cast<const char*>(data) + 1, size - 1);
  const auto format = static_cast<api::BodyFormat>(data[0] % 4U);
  switch (data[0] / 4U % 6U) {
    case 0:
      return check_parsed(api::parse_session_scans(body, format, kLidar, kLimits));
    case 1:
      return check_parsed(api::parse_map_scans(body, format, kLidar, kLimits));
    case 2:
      return check_parsed(api::parse_localize(body, format, kLimits));
    case 3:
      return check_parsed(api::parse_create_session(body, format));
    case 4:
      return check_parsed(api::parse_put_map(body, format));
    default:
      return check_parsed(api::parse_trajectory(body, format));
  }
}

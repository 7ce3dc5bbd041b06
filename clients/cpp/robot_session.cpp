#include "clients/cpp/robot_session.hpp"

#include <utility>

#include "clients/cpp/scan_json.hpp"

namespace cornerfix::client {

RobotSession::RobotSession(RobotSessionOptions options, evaluation::LogHeader header,
                           ServerConnection& server)
    : options_(std::move(options)), header_(std::move(header)), server_(server) {}

Result<void> RobotSession::open() {
  nlohmann::ordered_json body = {{"robot", options_.robot}, {"map", nullptr}};
  if (!options_.map.empty()) body["map"] = options_.map;
  body["lidar"] = lidar_json(header_);
  const auto answer = server_.call({"POST", "/v1/sessions", body.dump(), /*creates_session=*/true});
  if (!answer) return answer.error();
  id_ = server_.is_printing() ? std::string(kSessionVariable)
                              : percent_encode(answer->value("id", ""));
  return {};
}

Result<nlohmann::json> RobotSession::post(std::span<const evaluation::LogScan> batch) {
  auto scans = nlohmann::ordered_json::array();
  for (const evaluation::LogScan& scan : batch)
    scans.push_back(robot_scan_json(header_, scan, options_.posts_odometry));
  const nlohmann::ordered_json body = {{"sequence", sequence_++}, {"scans", std::move(scans)}};
  return server_.call({"POST", path() + "/scans", body.dump()});
}

Result<void> RobotSession::reset() {
  const auto answer = server_.call({"POST", path() + "/reset"});
  if (!answer) return answer.error();
  return {};
}

Result<void> RobotSession::close() {
  const auto answer = server_.call({"DELETE", path()});
  if (!answer) return answer.error();
  return {};
}

}  // namespace cornerfix::client

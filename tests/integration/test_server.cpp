#include "integration/test_server.hpp"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <stdexcept>

namespace cornerfix::testing {
namespace {

Json ranges_json(const LaserScan& scan) {
  Json ranges = Json::array();
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    ranges.push_back(scan.has_return(beam) ? Json(scan.ranges[beam]) : Json(nullptr));
  }
  return ranges;
}

std::vector<std::string> with_command(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "serve");
  return arguments;
}

}  // namespace

TestServer::TestServer(const std::filesystem::path& database, server::ServerConfig config) {
  spdlog::set_level(spdlog::level::off);
  config.database = database;
  config.port = 0;
  auto started = server::HttpServer::start(config);
  if (!started) throw std::runtime_error(started.error().message);
  server_ = std::move(*started);
  thread_ = std::thread([this] { EXPECT_TRUE(server_->run()); });
}

TestServer::~TestServer() {
  server_->drain();
  thread_.join();
}

ServerProcess::ServerProcess(const std::vector<std::string>& arguments)
    : program_(CORNERFIX_PROGRAM, with_command(arguments)), first_line_(program_.read_line()) {
  const auto colon = first_line_.rfind(':');
  if (colon != std::string::npos) port_ = std::stoi(first_line_.substr(colon + 1));
}

Json pose_json(const Pose2& pose) { return {{"x", pose.x}, {"y", pose.y}, {"yaw", pose.yaw}}; }

Json lidar_json() {
  const LaserScan scan = scan_in_room({5.0, 5.0, 0.0}, 0.0);
  return {{"angle_min", scan.angle_min},
          {"angle_increment", scan.angle_increment},
          {"range_min", scan.range_min},
          {"range_max", scan.range_max}};
}

Json map_batch(const std::vector<PosedScan>& drive, std::size_t begin, std::size_t count) {
  Json scans = Json::array();
  for (std::size_t i = begin; i < std::min(begin + count, drive.size()); ++i) {
    scans.push_back({{"stamp", drive[i].scan.stamp},
                     {"ranges", ranges_json(drive[i].scan)},
                     {"pose", pose_json(drive[i].T_map_base_link)}});
  }
  return {{"lidar", lidar_json()}, {"scans", scans}};
}

Json session_batch(const RobotDrive& drive, std::uint64_t sequence, std::size_t count) {
  Json scans = Json::array();
  for (std::size_t i = sequence * count; i < (sequence + 1) * count; ++i) {
    scans.push_back({{"stamp", drive.scans.at(i).scan.stamp},
                     {"ranges", ranges_json(drive.scans[i].scan)},
                     {"odom", pose_json(*drive.scans[i].T_odom_base_link)}});
  }
  return {{"sequence", sequence}, {"scans", scans}};
}

Json session_request(const std::string& robot, const Json& map) {
  return {{"robot", robot}, {"map", map}, {"lidar", lidar_json()}};
}

void make_room_map(HttpClient& client, const std::string& name) {
  ASSERT_EQ(client.put("/v1/maps/" + name, {{"lidar", lidar_json()}}).status, 201);
  const Reply reply = client.post("/v1/maps/" + name + "/scans", map_batch(mapping_drive(), 0, 48));
  ASSERT_EQ(reply.status, 200) << reply.body;
}

std::string open_session(HttpClient& client, const std::string& robot, const Json& map) {
  const Reply reply = client.post("/v1/sessions", session_request(robot, map));
  EXPECT_EQ(reply.status, 201) << reply.body;
  return reply.json().value("id", "");
}

}  // namespace cornerfix::testing

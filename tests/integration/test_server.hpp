/// \file  The real server on a free port and a database of its own, in this process or as a
/// program.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "integration/http_client.hpp"
#include "server/http_server.hpp"
#include "server/server_config.hpp"
#include "support/program.hpp"
#include "support/room_drive.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::testing {

/// A server in this process. Drains when it goes out of scope.
class TestServer {
 public:
  explicit TestServer(const std::filesystem::path& database, server::ServerConfig config = {});
  ~TestServer();

  [[nodiscard]] int port() const { return server_->port(); }
  void drain() { server_->drain(); }

 private:
  std::unique_ptr<server::HttpServer> server_;
  std::thread thread_;
};

/// `cornerfix serve` as a process of its own. Killed when it goes out of scope.
class ServerProcess {
 public:
  explicit ServerProcess(const std::vector<std::string>& arguments);

  /// Of the line it says when it is ready; 0 when it ended without one.
  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] const std::string& first_line() const { return first_line_; }
  void signal(int number) const { program_.signal(number); }
  /// The exit code, or minus the signal that ended it. All it said after the first line is in
  /// `rest_of_output`.
  int wait() { return program_.wait(); }
  [[nodiscard]] const std::string& rest_of_output() const { return program_.rest_of_output(); }

 private:
  Program program_;
  std::string first_line_;
  int port_ = 0;
};

[[nodiscard]] Json pose_json(const Pose2& pose);
/// The lidar of all scans of room_drive.hpp.
[[nodiscard]] Json lidar_json();
/// A batch for POST /v1/maps/{map}/scans.
[[nodiscard]] Json map_batch(const std::vector<PosedScan>& drive, std::size_t begin,
                             std::size_t count);
/// A batch for POST /v1/sessions/{id}/scans: the scans that come at `sequence` when all have
/// `count`.
[[nodiscard]] Json session_batch(const RobotDrive& drive, std::uint64_t sequence,
                                 std::size_t count = 3);
[[nodiscard]] Json session_request(const std::string& robot, const Json& map);

/// Makes a map of the room from mapping_drive().
void make_room_map(HttpClient& client, const std::string& name);
/// Opens a session and returns its id.
[[nodiscard]] std::string open_session(HttpClient& client, const std::string& robot,
                                       const Json& map);

}  // namespace cornerfix::testing

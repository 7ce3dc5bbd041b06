/// \file  A session of one robot on a server: it posts the scans of a log batch by batch.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "clients/cpp/server_connection.hpp"
#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::client {

struct RobotSessionOptions {
  std::string robot = {};      ///< Name of the robot.
  std::string map = {};        ///< Map to look in; empty for all maps of the server.
  bool posts_odometry = true;  ///< Where the scans have any.
};

/// The connection outlives the session. One thread at a time.
class RobotSession {
 public:
  RobotSession(RobotSessionOptions options, evaluation::LogHeader header, ServerConnection& server);

  /// Makes the session; to be called first.
  [[nodiscard]] Result<void> open();
  /// The server's answer; null when the connection only prints.
  [[nodiscard]] Result<nlohmann::json> post(std::span<const evaluation::LogScan> batch);
  /// Forgets the pose, since the robot may have been moved.
  [[nodiscard]] Result<void> reset();
  /// Deletes the session.
  [[nodiscard]] Result<void> close();

 private:
  [[nodiscard]] std::string path() const { return "/v1/sessions/" + id_; }

  RobotSessionOptions options_;
  evaluation::LogHeader header_;
  ServerConnection& server_;
  std::string id_;  ///< Percent-encoded.
  std::size_t sequence_ = 0;
};

}  // namespace cornerfix::client

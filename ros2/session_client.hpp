/// \file  A robot's session on the server, over HTTP.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <cornerfix/result.hpp>

#include "ros2/answer.hpp"
#include "ros2/bridge_options.hpp"
#include "ros2/scan_assembler.hpp"

namespace cornerfix::ros2 {

/// Whose session it is, and where the robot may be.
struct SessionOptions {
  std::string robot;
  std::vector<std::string> maps;      ///< Empty for all maps of the server.
  std::vector<std::string> lidars{};  ///< Names of several lidars; empty for one.
  std::optional<StartRegion> near{};  ///< Of the first session: later the robot has moved.
};

/// Sends one request at a time; stop() may be called from another thread.
class SessionClient {
 public:
  SessionClient(const ServerAddress& server, SessionOptions options);
  ~SessionClient();
  SessionClient(const SessionClient&) = delete;
  SessionClient& operator=(const SessionClient&) = delete;

  /// What is wrong with the maps or the token, as far as the server can be reached.
  [[nodiscard]] std::optional<Error> check();

  struct Outcome {
    enum class Kind {
      kAnswered,
      kTryAgain,  ///< Post the same batch after `wait`.
      kRefused,   ///< The server cannot take this batch; go on with the next one.
    };
    Kind kind = Kind::kTryAgain;
    std::optional<Answer> answer;
    std::string problem;  ///< For people; empty when there is none.
    std::chrono::milliseconds wait{0};
  };

  /// One attempt to post scans. Opens a session where there is none, and a new one
  /// when the first scan begins a run or the old session is gone.
  [[nodiscard]] Outcome post(std::span<const AssembledScan> batch);

  /// Deletes the session, without waiting long.
  void close();

  /// Breaks off a request that is in work.
  void stop();

 private:
  class Connection;

  [[nodiscard]] std::optional<Outcome> open(const AssembledScan& first);
  [[nodiscard]] Outcome fail_unreachable();
  [[nodiscard]] Outcome fail(int status, const std::string& body, int retry_after_s);

  std::unique_ptr<Connection> connection_;
  std::string url_;
  SessionOptions options_;
  std::string session_;  ///< Empty when there is none.
  std::uint64_t sequence_ = 0;
  bool is_run_begun_ = false;  ///< The session is of the run that the batch begins.
  int failures_ = 0;           ///< Without an answer, one after the other.
};

}  // namespace cornerfix::ros2

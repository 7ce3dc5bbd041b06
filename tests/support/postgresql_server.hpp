/// \file  A real PostgreSQL server for the tests of one program: started when it is first asked
/// for, stopped when the program ends.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/temporary_directory.hpp"

namespace cornerfix::testing {

class PostgresqlServer {
 public:
  static PostgresqlServer& shared() {
    static PostgresqlServer server;
    return server;
  }

  PostgresqlServer(const PostgresqlServer&) = delete;
  PostgresqlServer& operator=(const PostgresqlServer&) = delete;
  ~PostgresqlServer() {
    if (is_running_) (void)control("crash");
  }

  /// False where PostgreSQL is not installed. CORNERFIX_REQUIRE_TOOLS makes that a failure.
  [[nodiscard]] bool is_installed() const { return status_ != kNotInstalled; }
  [[nodiscard]] bool is_running() const { return is_running_; }
  [[nodiscard]] static bool is_required() {
    return std::getenv("CORNERFIX_REQUIRE_TOOLS") != nullptr;
  }

  [[nodiscard]] std::string url(const std::string& database) const {
    return "postgresql:///" + database + "?host=" + directory_.path().string() + "&user=cornerfix";
  }

  void start() {
    status_ = control("start", std::to_string(::getpid()));
    is_running_ = status_ == 0;
  }
  /// As a crash of the server: connections end without a word.
  void crash() {
    (void)control("crash");
    is_running_ = false;
  }

 private:
  static constexpr int kNotInstalled = 77;

  PostgresqlServer() { start(); }

  [[nodiscard]] int control(const std::string& action, const std::string& owner = "") const {
    const std::string command = "bash '" CORNERFIX_SOURCE_DIR "/tests/support/postgresql.sh' " +
                                action + " '" + directory_.path().string() + "' " + owner;
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  TemporaryDirectory directory_;
  int status_ = 0;
  bool is_running_ = false;
};

}  // namespace cornerfix::testing

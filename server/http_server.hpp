/// \file  The HTTP side of the service: limits, time-outs, tokens, files, the log, draining.
#pragma once

#include <memory>
#include <vector>

#include <cornerfix/result.hpp>

#include "server/server_config.hpp"

namespace cornerfix::server {

class HttpServer {
 public:
  /// Opens the database and binds the address, but answers nobody yet.
  [[nodiscard]] static Result<std::unique_ptr<HttpServer>> start(const ServerConfig& config);

  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// The port it is bound to.
  [[nodiscard]] int port() const;

  /// Serves until drain() is called; then finishes what is open and returns true. False when the
  /// socket failed.
  [[nodiscard]] bool run();

  /// Stores what checkpoints have not stored yet, but for sessions within a batch. Returns how many
  /// sessions could not be stored. Any thread may call.
  [[nodiscard]] std::size_t store_sessions();

  /// Requests are checked by these tokens from now on. Any thread may call.
  void set_tokens(std::vector<Token> tokens);

  /// Takes no new connection, answers what was sent, closes every connection with its next
  /// answer. Any thread may call, also before run().
  void drain();

 private:
  struct Impl;
  explicit HttpServer(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace cornerfix::server

/// \file  How a command sends requests to its server, or prints them.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include <cornerfix/result.hpp>

#include "cli/curl.hpp"
#include "cli/http_client.hpp"

namespace cornerfix::cli {

struct ConnectionOptions {
  ServerAddress server;
  bool print_curl = false;
};

/// --server and --token.
void add_server_options(CLI::App& command, ServerAddress& server);

/// --server, --token and --print-curl, which every client command takes.
void add_connection_options(CLI::App& command, ConnectionOptions& options);

/// Not yet connected when made. One thread at a time.
class ServerConnection {
 public:
  [[nodiscard]] static Result<ServerConnection> open(const ConnectionOptions& options);

  /// The answer's JSON, null where it has no body. With --print-curl nothing is sent: the curl line
  /// goes to stdout, and the answer is null.
  [[nodiscard]] Result<nlohmann::json> call(const HttpRequest& request);

  /// The answer's bytes; empty with --print-curl.
  [[nodiscard]] Result<std::string> fetch(const HttpRequest& request);

  /// Whether answers are only null, since nothing is sent.
  [[nodiscard]] bool is_printing() const { return curl_.has_value(); }

 private:
  explicit ServerConnection(HttpClient client) : client_(std::move(client)) {}
  [[nodiscard]] Result<nlohmann::json> print(const HttpRequest& request);

  HttpClient client_;
  std::optional<CurlWriter> curl_;
};

}  // namespace cornerfix::cli

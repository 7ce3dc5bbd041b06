/// \file  How a command sends requests to its server, or prints them.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include <cornerfix/result.hpp>

#include "clients/cpp/curl.hpp"
#include "clients/cpp/http_client.hpp"

namespace cornerfix::cli {

struct ConnectionOptions {
  client::ServerAddress server;
  bool print_curl = false;
};

/// --server and --token.
void add_server_options(CLI::App& command, client::ServerAddress& server);

/// --server, --token and --print-curl, which every client command takes.
void add_connection_options(CLI::App& command, ConnectionOptions& options);

/// Not yet connected when made. One thread at a time.
class ServerConnection {
 public:
  [[nodiscard]] static Result<ServerConnection> open(const ConnectionOptions& options);

  /// The answer's JSON, null where it has no body. With --print-curl nothing is sent: the curl line
  /// goes to stdout, and the answer is null.
  [[nodiscard]] Result<nlohmann::json> call(const client::HttpRequest& request);

  /// The answer's bytes; empty with --print-curl.
  [[nodiscard]] Result<std::string> fetch(const client::HttpRequest& request);

  /// Whether answers are only null, since nothing is sent.
  [[nodiscard]] bool is_printing() const { return curl_.has_value(); }

 private:
  explicit ServerConnection(client::HttpClient client) : client_(std::move(client)) {}
  [[nodiscard]] Result<nlohmann::json> print(const client::HttpRequest& request);

  client::HttpClient client_;
  std::optional<client::CurlWriter> curl_;
};

}  // namespace cornerfix::cli

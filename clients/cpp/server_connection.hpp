/// \file  Sends calls to a server, or prints them as curl lines.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include <cornerfix/result.hpp>

#include "clients/cpp/curl.hpp"
#include "clients/cpp/http_client.hpp"

namespace cornerfix::client {

struct ConnectionOptions {
  ServerAddress server;
  bool print_curl = false;  ///< Send nothing and print the equivalent curl lines.
};

/// Not yet connected when made. One thread at a time.
class ServerConnection {
 public:
  [[nodiscard]] static Result<ServerConnection> open(const ConnectionOptions& options);

  /// The answer's JSON, null where it has no body. With `print_curl` nothing is sent: the curl line
  /// goes to stdout, and the answer is null.
  [[nodiscard]] Result<nlohmann::json> call(const HttpRequest& request);

  /// The answer's bytes; empty with `print_curl`.
  [[nodiscard]] Result<std::string> fetch(const HttpRequest& request);

  /// Whether answers are only null, since nothing is sent.
  [[nodiscard]] bool is_printing() const { return curl_.has_value(); }

 private:
  explicit ServerConnection(HttpClient client) : client_(std::move(client)) {}
  [[nodiscard]] Result<nlohmann::json> print(const HttpRequest& request);

  HttpClient client_;
  std::optional<CurlWriter> curl_;
};

}  // namespace cornerfix::client

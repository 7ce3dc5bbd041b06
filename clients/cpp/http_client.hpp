/// \file  Sends calls to a server over one connection that is kept.
#pragma once

#include <memory>
#include <string>

#include <cornerfix/result.hpp>

#include "clients/cpp/http_request.hpp"

namespace cornerfix::client {

/// Any answer, also one of an error.
struct HttpReply {
  int status = 0;
  std::string body;
};

/// One thread at a time.
class HttpClient {
 public:
  /// Does not connect yet. kInvalidArgument for what is not an http URL.
  [[nodiscard]] static Result<HttpClient> create(const ServerAddress& server);
  ~HttpClient();
  HttpClient(HttpClient&&) noexcept;

  /// The body of a 2xx answer; any other is an Error with what the server's problem document says
  /// and a code that fits. Waits and asks again when the server says so (429, 503), and once more
  /// when the connection broke under a request that may be repeated.
  [[nodiscard]] Result<std::string> send(const HttpRequest& request);

  /// Sends once and does not wait for any answer. kUnavailable without one.
  [[nodiscard]] Result<HttpReply> ask(const HttpRequest& request);

 private:
  class Connection;
  explicit HttpClient(std::unique_ptr<Connection> connection);

  std::unique_ptr<Connection> connection_;
};

}  // namespace cornerfix::client

/// \file  A call of the HTTP API, before it is sent or printed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cornerfix::client {

/// Where the server is and who asks.
struct ServerAddress {
  std::string url = "http://127.0.0.1:8080";  ///< May end in a path that all calls begin with.
  std::string token;                          ///< Bearer token; empty for none.
};

/// A file as a part of a form.
struct FormFile {
  std::string part;
  std::string path;
  std::string content;
};

struct HttpRequest {
  std::string method;               ///< "GET", "PUT", ...
  std::string path;                 ///< Percent-encoded, with its query: "/v1/maps?limit=10".
  std::string body = {};            ///< JSON; empty for none.
  bool creates_session = false;     ///< All other calls do the same when they are sent twice.
  std::vector<FormFile> form = {};  ///< When not empty, the body is this form.
  std::string content_type = "application/json";
  std::string body_path = {};    ///< The file that `body` was read from, for printing.
  std::string answer_path = {};  ///< The file that the answer goes to, for printing.
};

/// A name as a part of a path: all but unreserved characters as %XX.
[[nodiscard]] std::string percent_encode(std::string_view text);

}  // namespace cornerfix::client

/// \file  A plain HTTP client for tests: documents in, replies out; and one that sends bytes.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "support/raw_connection.hpp"

namespace cornerfix::testing {

using Json = nlohmann::json;
using HeaderMap = std::multimap<std::string, std::string>;

struct Reply {
  int status = 0;     ///< 0: the connection failed, and `body` names the error.
  HeaderMap headers;  ///< Names in lower case.
  std::string body;

  [[nodiscard]] Json json() const { return Json::parse(body); }
  /// The first value of a header, or "".
  [[nodiscard]] std::string header(const std::string& name) const;
};

/// One keep-alive connection.
class HttpClient {
 public:
  explicit HttpClient(int port);
  ~HttpClient();
  HttpClient(HttpClient&&) noexcept;

  /// Sent with every request from now on.
  void set_header(const std::string& name, const std::string& value);

  Reply get(const std::string& path, const HeaderMap& headers = {});
  Reply remove(const std::string& path);
  Reply put(const std::string& path, const Json& document);
  Reply post(const std::string& path, const Json& document);
  /// Any method, any bytes.
  Reply send(const std::string& method, const std::string& path, const std::string& body,
             const std::string& content_type, const HeaderMap& headers = {});
  /// A POST in chunks.
  Reply post_chunked(const std::string& path, const std::string& body,
                     const std::string& content_type);
  /// Reads a stream until `take` returns false.
  Reply stream(const std::string& path, const std::function<bool(std::string_view)>& take);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Sends `request` on a connection of its own and reads until the server closes it.
[[nodiscard]] std::string exchange_bytes(int port, std::string_view request);

}  // namespace cornerfix::testing

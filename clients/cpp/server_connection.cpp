#include "clients/cpp/server_connection.hpp"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>

namespace cornerfix::client {

namespace {

/// Of this process alone, so that lines printed by two commands do not share their bodies.
std::filesystem::path curl_body_directory() {
  std::error_code error;
  std::filesystem::path directory = std::filesystem::temp_directory_path(error);
  if (error) directory = ".";
  return directory / ("cornerfix-curl-" + std::to_string(getpid()));
}

}  // namespace

Result<ServerConnection> ServerConnection::open(const ConnectionOptions& options) {
  Result<HttpClient> client = HttpClient::create(options.server);
  if (!client) return client.error();
  ServerConnection connection(std::move(*client));
  if (options.print_curl) connection.curl_.emplace(options.server, curl_body_directory());
  return connection;
}

Result<nlohmann::json> ServerConnection::call(const HttpRequest& request) {
  if (curl_) return print(request);
  const Result<std::string> body = client_.send(request);
  if (!body) return body.error();
  if (body->empty()) return nlohmann::json();
  nlohmann::json json = nlohmann::json::parse(*body, nullptr, false);
  if (json.is_discarded()) {
    return Error{ErrorCode::kInternal, "the answer is not JSON; is this a Cornerfix server?",
                 request.method + " " + request.path};
  }
  return json;
}

Result<std::string> ServerConnection::fetch(const HttpRequest& request) {
  if (!curl_) return client_.send(request);
  const Result<nlohmann::json> printed = print(request);
  if (!printed) return printed.error();
  return std::string();
}

Result<nlohmann::json> ServerConnection::print(const HttpRequest& request) {
  const Result<std::string> line = curl_->line(request);
  if (!line) return line.error();
  std::printf("%s\n", line->c_str());
  return nlohmann::json();
}

}  // namespace cornerfix::client

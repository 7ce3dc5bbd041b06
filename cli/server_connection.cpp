#include "cli/server_connection.hpp"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>

namespace cornerfix::cli {

namespace {

/// Of this process alone, so that lines printed by two commands do not share their bodies.
std::filesystem::path curl_body_directory() {
  std::error_code error;
  std::filesystem::path directory = std::filesystem::temp_directory_path(error);
  if (error) directory = ".";
  return directory / ("cornerfix-curl-" + std::to_string(getpid()));
}

CLI::Validator server_url() {
  return {[](std::string& url) {
            const auto client = client::HttpClient::create({.url = url, .token = {}});
            return client ? std::string() : client.error().message + ", not " + url;
          },
          "URL"};
}

}  // namespace

void add_server_options(CLI::App& command, client::ServerAddress& server) {
  command.add_option("--server", server.url, "URL of the server")
      ->check(server_url())
      ->capture_default_str()
      ->group("Server");
  command.add_option("--token", server.token, "Token, where the server asks for one")
      ->envname("CORNERFIX_TOKEN")
      ->group("Server");
}

void add_connection_options(CLI::App& command, ConnectionOptions& options) {
  add_server_options(command, options.server);
  command
      .add_flag("--print-curl", options.print_curl,
                "Print the equivalent curl lines, send nothing; large bodies go to files")
      ->group("Server");
}

Result<ServerConnection> ServerConnection::open(const ConnectionOptions& options) {
  Result<client::HttpClient> client = client::HttpClient::create(options.server);
  if (!client) return client.error();
  ServerConnection connection(std::move(*client));
  if (options.print_curl) connection.curl_.emplace(options.server, curl_body_directory());
  return connection;
}

Result<nlohmann::json> ServerConnection::call(const client::HttpRequest& request) {
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

Result<std::string> ServerConnection::fetch(const client::HttpRequest& request) {
  if (!curl_) return client_.send(request);
  const Result<nlohmann::json> printed = print(request);
  if (!printed) return printed.error();
  return std::string();
}

Result<nlohmann::json> ServerConnection::print(const client::HttpRequest& request) {
  const Result<std::string> line = curl_->line(request);
  if (!line) return line.error();
  std::printf("%s\n", line->c_str());
  return nlohmann::json();
}

}  // namespace cornerfix::cli

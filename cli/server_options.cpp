#include "cli/server_options.hpp"

#include <string>

namespace cornerfix::cli {

namespace {

CLI::Validator server_url() {
  return {[](std::string& url) {
            const auto created = client::HttpClient::create({.url = url, .token = {}});
            return created ? std::string() : created.error().message + ", not " + url;
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

void add_connection_options(CLI::App& command, client::ConnectionOptions& options) {
  add_server_options(command, options.server);
  command
      .add_flag("--print-curl", options.print_curl,
                "Print the equivalent curl lines, send nothing; large bodies go to files")
      ->group("Server");
}

}  // namespace cornerfix::cli

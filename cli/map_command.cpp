#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "cli/map_commands.hpp"
#include "cli/server_options.hpp"
#include "cli/table.hpp"

namespace cornerfix::cli {

namespace {

struct MapArguments {
  client::ConnectionOptions connection;
  std::string name;
};

std::string path_of(const std::string& map) { return "/v1/maps/" + client::percent_encode(map); }

std::string text(const nlohmann::json& object, const char* key) {
  const auto member = object.find(key);
  if (member == object.end() || member->is_null()) return "-";
  return member->is_string() ? member->get<std::string>() : member->dump();
}

/// "58.2 x 47.3 m", or "-" for a map without content.
std::string size_text(const nlohmann::json& map) {
  const auto bounds = map.find("bounds");
  if (bounds == map.end() || !bounds->is_object()) return "-";
  char out[64];
  std::snprintf(out, sizeof out, "%.1f x %.1f m",
                bounds->value("max_x", 0.0) - bounds->value("min_x", 0.0),
                bounds->value("max_y", 0.0) - bounds->value("min_y", 0.0));
  return out;
}

int list_maps(const client::ConnectionOptions& options) {
  Result<client::ServerConnection> server = client::ServerConnection::open(options);
  if (!server) return fail(server.error());
  std::vector<std::vector<std::string>> rows = {
      {"NAME", "REVISION", "KEYFRAMES", "FEATURES", "SIZE", "UPDATED"}};
  std::string page_token;
  do {
    const std::string query =
        page_token.empty() ? "" : "?page_token=" + client::percent_encode(page_token);
    const Result<nlohmann::json> page = server->call({"GET", "/v1/maps" + query});
    if (!page) return fail(page.error());
    if (server->is_printing()) return kDone;
    for (const auto& map : page->value("maps", nlohmann::json::array())) {
      rows.push_back({text(map, "name"), text(map, "revision"), text(map, "keyframes"),
                      text(map, "features"), size_text(map), text(map, "updated")});
    }
    const auto next = page->find("next_page_token");
    page_token = next != page->end() && next->is_string() ? next->get<std::string>() : "";
  } while (!page_token.empty());
  print_table(rows);
  return kDone;
}

int show_map(const MapArguments& arguments) {
  Result<client::ServerConnection> server = client::ServerConnection::open(arguments.connection);
  if (!server) return fail(server.error());
  const Result<nlohmann::json> map = server->call({"GET", path_of(arguments.name)});
  if (!map) return fail(map.error());
  if (!server->is_printing()) std::printf("%s\n", map->dump(2).c_str());
  return kDone;
}

int delete_map(const MapArguments& arguments) {
  Result<client::ServerConnection> server = client::ServerConnection::open(arguments.connection);
  if (!server) return fail(server.error());
  const Result<nlohmann::json> answer = server->call({"DELETE", path_of(arguments.name)});
  if (!answer) return fail(answer.error());
  if (!server->is_printing()) std::printf("%s: deleted\n", arguments.name.c_str());
  return kDone;
}

using MapFunction = int (*)(const MapArguments&);

void add_named_command(CLI::App& map, const char* name, const char* help, MapFunction function,
                       int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* command = map.add_subcommand(name, help);
  add_map_name(*command, arguments->name);
  add_connection_options(*command, arguments->connection);
  command->callback([arguments, function, &exit_code] { exit_code = function(*arguments); });
}

void add_list_command(CLI::App& map, int& exit_code) {
  auto options = std::make_shared<client::ConnectionOptions>();
  CLI::App* command = map.add_subcommand("list", "List the server's maps");
  add_connection_options(*command, *options);
  command->callback([options, &exit_code] { exit_code = list_maps(*options); });
}

}  // namespace

void add_database_option(CLI::App& command, std::string& database) {
  CLI::Option* option = command.add_option(
      "--db", database, "Write into this database file instead of asking a server");
  for (const char* other : {"--server", "--token", "--print-curl"})
    option->excludes(command.get_option(other));
}

void add_map_command(CLI::App& app, int& exit_code) {
  CLI::App* map = app.add_subcommand("map", "Make, list, show, copy and delete maps");
  map->require_subcommand(1);
  add_map_build_command(*map, exit_code);
  add_map_import_command(*map, exit_code);
  add_map_export_command(*map, exit_code);
  add_map_restore_command(*map, exit_code);
  add_list_command(*map, exit_code);
  add_named_command(*map, "show", "Show the properties of a map", show_map, exit_code);
  add_map_report_command(*map, exit_code);
  add_named_command(*map, "delete", "Delete a map", delete_map, exit_code);
}

}  // namespace cornerfix::cli

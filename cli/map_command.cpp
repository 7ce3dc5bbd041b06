#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "cli/map_archive.hpp"
#include "cli/map_build.hpp"
#include "cli/map_import.hpp"
#include "cli/map_report.hpp"
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
      {"NAME", "REVISION", "KEY FRAMES", "FEATURES", "SIZE", "UPDATED"}};
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

void add_build_command(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<MapBuildArguments>();
  CLI::App* command = map.add_subcommand("build", "Make a map from a log, or update a map by it");
  command->footer(
      "A log is JSON lines (.jsonl) or CARMEN (.log, .clf, .gfs), also with .gz, or a bag of ROS "
      "1\n"
      "or 2 (.bag, .mcap, .db3). Its poses must be corrected ones: of CARMEN those of the laser, "
      "of\n"
      "bags those that tf knows in the frame map. Where a log marks key scans, only those make "
      "the\n"
      "map. With --slam all scans do, and their poses are found. Scans that the map has already "
      "are\n"
      "skipped, so the same log may be sent again. A later drive in the map's building and frame\n"
      "updates it: where that drive looked, what is gone leaves the map.");
  add_map_name(*command, arguments->name);
  add_log(*command, arguments->log);
  command->add_option("--split", arguments->scans.split, "Use this first share of the log only")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--stride", arguments->scans.stride, "Use every n-th scan")
      ->check(above_zero())
      ->capture_default_str();
  command->add_flag("--slam", arguments->scans.without_poses,
                    "Find the poses from scans and odometry instead of taking the log's");
  add_selection(*command, arguments->scans.selection);
  CLI::Option* database = command->add_option(
      "--db", arguments->database, "Write into this database file instead of asking a server");
  add_connection_options(*command, arguments->connection);
  for (const char* option : {"--server", "--token", "--print-curl"}) {
    database->excludes(command->get_option(option));
  }
  command->callback([arguments, &exit_code] { exit_code = run_map_build(*arguments); });
}

/// Returns its FILE.
CLI::Option* add_archive_command(CLI::App& map, const char* name, const char* help,
                                 const char* file_help, int (*run)(const MapArchiveArguments&),
                                 int& exit_code) {
  auto arguments = std::make_shared<MapArchiveArguments>();
  CLI::App* command = map.add_subcommand(name, help);
  add_map_name(*command, arguments->name);
  CLI::Option* file = command->add_option("FILE", arguments->file, file_help)->required();
  add_connection_options(*command, arguments->connection);
  command->callback([arguments, run, &exit_code] { exit_code = run(*arguments); });
  return file;
}

void add_report_command(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<MapReportArguments>();
  CLI::App* command = map.add_subcommand(
      "report", "Tell where robots will find themselves in a map, and where not");
  command->footer(
      "Simulated robots are switched on all over the map's free space and drive until they are\n"
      "told their pose. They have the map's lidar, or half a turn with 30 m of reach.");
  add_map_name(*command, arguments->name);
  command->add_option("--picture", arguments->picture, "Draw it into this file (SVG)");
  add_connection_options(*command, arguments->connection);
  command->callback([arguments, &exit_code] { exit_code = run_map_report(*arguments); });
}

void add_import_command(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<MapImportArguments>();
  CLI::App* command =
      map.add_subcommand("import", "Make a map from a ROS floor map alone, without any scan");
  command->footer(
      "A floor map is a yaml and a pgm or png as ROS map_server has them. Features come from "
      "virtual\nscans in its free space. Imported again, a floor map replaces the one that the map "
      "was made from.");
  add_map_name(*command, arguments->name);
  command->add_option("YAML", arguments->yaml, "The floor map's yaml; its image lies beside it")
      ->required()
      ->check(CLI::ExistingFile);
  CLI::Option* database = command->add_option(
      "--db", arguments->database, "Write into this database file instead of asking a server");
  add_connection_options(*command, arguments->connection);
  for (const char* option : {"--server", "--token", "--print-curl"}) {
    database->excludes(command->get_option(option));
  }
  command->callback([arguments, &exit_code] { exit_code = run_map_import(*arguments); });
}

}  // namespace

void add_map_command(CLI::App& app, int& exit_code) {
  CLI::App* map = app.add_subcommand("map", "Make, list, show, carry and delete maps");
  map->require_subcommand(1);
  add_build_command(*map, exit_code);
  add_import_command(*map, exit_code);
  add_archive_command(*map, "export", "Write a map into one file", "Where to write it",
                      run_map_export, exit_code);
  add_archive_command(*map, "restore", "Make a map of the file that export wrote", "The file",
                      run_map_restore, exit_code)
      ->check(CLI::ExistingFile);
  add_list_command(*map, exit_code);
  add_named_command(*map, "show", "Show what the server knows of a map", show_map, exit_code);
  add_report_command(*map, exit_code);
  add_named_command(*map, "delete", "Delete a map", delete_map, exit_code);
}

}  // namespace cornerfix::cli

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "cli/command.hpp"
#include "cli/map_commands.hpp"
#include "cli/server_options.hpp"
#include "server/responses.hpp"

namespace cornerfix::cli {

namespace {

struct MapArchiveArguments {
  client::ConnectionOptions connection;
  std::string name;
  std::string file;
};

std::string archive_path(const std::string& map) {
  return "/v1/maps/" + client::percent_encode(map) + "/archive";
}

Result<std::string> read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) return Error{ErrorCode::kUnavailable, "cannot be read", path};
  return bytes;
}

int run_map_export(const MapArchiveArguments& arguments) {
  Result<client::ServerConnection> server = client::ServerConnection::open(arguments.connection);
  if (!server) return fail(server.error());
  client::HttpRequest request{"GET", archive_path(arguments.name)};
  request.answer_path = arguments.file;
  const Result<std::string> bytes = server->fetch(request);
  if (!bytes) return fail(bytes.error());
  if (server->is_printing()) return kDone;
  if (const auto written = write_file(arguments.file, *bytes); !written)
    return fail(written.error());
  std::printf("%s: %zu bytes in %s\n", arguments.name.c_str(), bytes->size(),
              arguments.file.c_str());
  return kDone;
}

int run_map_restore(const MapArchiveArguments& arguments) {
  Result<std::string> bytes = read_file(arguments.file);
  if (!bytes) return fail(bytes.error());
  if (bytes->empty())
    return fail({ErrorCode::kInvalidArgument, "is empty, so it is no map", arguments.file});
  Result<client::ServerConnection> server = client::ServerConnection::open(arguments.connection);
  if (!server) return fail(server.error());
  client::HttpRequest request{"POST", archive_path(arguments.name), std::move(*bytes)};
  request.content_type = server::kArchiveType;
  request.body_path = arguments.file;
  const Result<nlohmann::json> map = server->call(request);
  if (!map) return fail(map.error());
  if (server->is_printing()) return kDone;
  std::printf("%s: restored, digest %s\n", arguments.name.c_str(),
              map->value("digest", std::string()).c_str());
  return kDone;
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

}  // namespace

void add_map_export_command(CLI::App& map, int& exit_code) {
  add_archive_command(map, "export", "Write a map into one file", "Where to write it",
                      run_map_export, exit_code);
}

void add_map_restore_command(CLI::App& map, int& exit_code) {
  add_archive_command(map, "restore", "Make a map of the file that export wrote", "The file",
                      run_map_restore, exit_code)
      ->check(CLI::ExistingFile);
}

}  // namespace cornerfix::cli

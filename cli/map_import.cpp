#include <cornerfix/map_image.hpp>

#include <cstdio>
#include <memory>
#include <span>
#include <utility>

#include "cli/command.hpp"
#include "cli/map_commands.hpp"
#include "cli/server_options.hpp"
#include "clients/cpp/map_upload.hpp"
#include "server/map_library.hpp"
#include "server/service_setup.hpp"
#include "server/store_access.hpp"

namespace cornerfix::cli {

namespace {

struct MapImportArguments {
  client::ConnectionOptions connection;
  std::string database;  ///< Where to write instead of asking a server; empty for the server.
  std::string name;
  std::string yaml;
};

Result<client::ImportedMap> import_over_http(const MapImportArguments& arguments, MapFiles files) {
  Result<client::ServerConnection> server = client::ServerConnection::open(arguments.connection);
  if (!server) return server.error();
  return client::upload_occupancy_map(*server, arguments.name, arguments.yaml, std::move(files));
}

Result<client::ImportedMap> import_into_file(const MapImportArguments& arguments,
                                             const MapFiles& files) {
  const auto stores = server::StoreAccess::open(arguments.database);
  if (!stores) return stores.error();
  server::MapLibrary library(*stores, {}, server::now_text);
  auto report =
      library.put_floor_map(arguments.name, files.yaml, std::as_bytes(std::span(files.image)));
  if (!report) {
    const Error& error = report.error();
    const bool is_of_image = error.field == "/image";
    return Error{error.code, error.message,
                 is_of_image ? files.image_path.string() : arguments.yaml + " " + error.field};
  }
  return client::ImportedMap{report->info.feature_count, report->info.revision,
                             std::move(report->warnings)};
}

int run_map_import(const MapImportArguments& arguments) {
  Result<MapFiles> files = load_map_files(arguments.yaml);
  if (!files) return fail(files.error());
  warn(arguments.yaml, files->note);
  const Result<client::ImportedMap> imported = arguments.database.empty()
                                                   ? import_over_http(arguments, std::move(*files))
                                                   : import_into_file(arguments, *files);
  if (!imported) return fail(imported.error());
  if (arguments.connection.print_curl) return kDone;
  for (const std::string& warning : imported->warnings)
    std::fprintf(stderr, "%s: %s\n", arguments.yaml.c_str(), warning.c_str());
  std::printf("%s: %zu features, revision %llu\n", arguments.name.c_str(), imported->features,
              static_cast<unsigned long long>(imported->revision));
  return kDone;
}

}  // namespace

void add_map_import_command(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<MapImportArguments>();
  CLI::App* command =
      map.add_subcommand("import", "Make a map from a ROS occupancy map alone, without any scan");
  command->footer(
      "An occupancy map is a yaml and a pgm or png as ROS map_server has them. Features come from\n"
      "simulated scans in its free space. Imported again, an occupancy map replaces the one that\n"
      "the map was made from.");
  add_map_name(*command, arguments->name);
  command
      ->add_option("YAML", arguments->yaml, "Yaml of the occupancy map; its image lies beside it")
      ->required()
      ->check(CLI::ExistingFile);
  add_connection_options(*command, arguments->connection);
  add_database_option(*command, arguments->database);
  command->callback([arguments, &exit_code] { exit_code = run_map_import(*arguments); });
}

}  // namespace cornerfix::cli

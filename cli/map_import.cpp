#include "cli/map_import.hpp"

#include <cornerfix/map_image.hpp>

#include <cstddef>
#include <cstdio>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "cli/command.hpp"
#include "server/map_library.hpp"
#include "server/store_access.hpp"

namespace cornerfix::cli {

namespace {

/// What the map became.
struct Imported {
  std::size_t features = 0;
  std::uint64_t revision = 0;
  std::vector<std::string> warnings;
};

/// A server takes bodies of 16 MiB, unless it is configured otherwise.
constexpr std::size_t kMaxImageBytes = std::size_t{15} << 20U;

/// The same cells as a png, which is a small part of a large pgm. Returns what the map's owner
/// should know about the files as they were.
Result<std::vector<std::string>> pack(MapFiles& files) {
  const auto image = std::as_bytes(std::span(files.image));
  const Result<OccupancyGrid> grid = parse_map(files.yaml, image);
  if (!grid) return Error{grid.error().code, grid.error().message, files.image_path.string()};
  std::vector<std::string> warnings;
  for (auto note : {thinning_note(files.yaml, *grid), threshold_advice(files.yaml, image)}) {
    if (note) warnings.push_back(std::move(*note));
  }
  const std::vector<std::byte> png = encode_grid_png(*grid);
  files.image.assign(reinterpret_cast<const char*>(png.data()), png.size());
  files.yaml = encode_grid_yaml(*grid, "image.png");
  return warnings;
}

Result<Imported> import_over_http(const MapImportArguments& arguments, MapFiles files) {
  Result<ServerConnection> server = ServerConnection::open(arguments.connection);
  if (!server) return server.error();
  std::vector<std::string> warnings;
  if (files.image.size() > kMaxImageBytes && !server->is_printing()) {
    auto packed = pack(files);
    if (!packed) return packed.error();
    warnings = std::move(*packed);
  }
  client::HttpRequest request{"PUT",
                              "/v1/maps/" + client::percent_encode(arguments.name) + "/grid"};
  request.form = {{"yaml", arguments.yaml, std::move(files.yaml)},
                  {"image", files.image_path.string(), std::move(files.image)}};
  const Result<nlohmann::json> answer = server->call(request);
  if (!answer) return answer.error();
  if (!answer->is_object()) return Imported{};  // Nothing was sent.
  Imported imported{answer->value("features", std::size_t{0}),
                    answer->value("revision", std::uint64_t{0}),
                    answer->value("warnings", std::vector<std::string>{})};
  imported.warnings.insert(imported.warnings.end(), warnings.begin(), warnings.end());
  return imported;
}

Result<Imported> import_into_file(const MapImportArguments& arguments, const MapFiles& files) {
  const auto stores = server::StoreAccess::open(arguments.database);
  if (!stores) return stores.error();
  server::MapLibrary library(*stores, {}, utc_now_text);
  auto report =
      library.put_floor_map(arguments.name, files.yaml, std::as_bytes(std::span(files.image)));
  if (!report) {
    const Error& error = report.error();
    const bool is_of_image = error.field == "/image";
    return Error{error.code, error.message,
                 is_of_image ? files.image_path.string() : arguments.yaml + " " + error.field};
  }
  return Imported{report->info.feature_count, report->info.revision, std::move(report->warnings)};
}

}  // namespace

int run_map_import(const MapImportArguments& arguments) {
  Result<MapFiles> files = load_map_files(arguments.yaml);
  if (!files) return fail(files.error());
  warn(arguments.yaml, files->note);
  const Result<Imported> imported = arguments.database.empty()
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

}  // namespace cornerfix::cli

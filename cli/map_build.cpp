#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "api/requests.hpp"
#include "cli/command.hpp"
#include "cli/map_commands.hpp"
#include "cli/progress.hpp"
#include "cli/server_options.hpp"
#include "clients/cpp/map_upload.hpp"
#include "clients/cpp/scan_json.hpp"
#include "evaluation/datasets/mapping_scans.hpp"
#include "server/map_library.hpp"
#include "server/service_setup.hpp"
#include "server/store_access.hpp"

namespace cornerfix::cli {

namespace {

struct MapBuildArguments {
  client::ConnectionOptions connection;
  std::string database;  ///< Where to write instead of asking a server; empty for the server.
  std::string name;
  std::string log;
  evaluation::MappingScanOptions scans;
};

constexpr std::size_t kScansPerBatch = 50;
const std::string kNothingNew =
    "the map holds scans of all its stamps already: nothing was added. Another run needs stamps "
    "of its own";
const std::string kPartlyKnown =
    " of its scans have stamps that the map holds already and were left out, as after an "
    "interruption. Another run needs stamps of its own";

using AddBatch = std::function<Result<client::MapGrowth>(std::span<const evaluation::LogScan>)>;

/// Adds all scans, a batch after the other. Returns the sums and the state of the map in the end.
Result<client::MapGrowth> add_in_batches(evaluation::MappingScans& scans, const AddBatch& add,
                                         Progress* progress) {
  client::MapGrowth total;
  for (auto batch = scans.next_batch(kScansPerBatch); !batch.empty();
       batch = scans.next_batch(kScansPerBatch)) {
    Result<client::MapGrowth> growth = add(batch);
    if (!growth) return growth;
    growth->accepted += total.accepted;
    growth->duplicates += total.duplicates;
    total = *growth;
    if (progress != nullptr) progress->update(scans.progress());
  }
  return total;
}

/// What a map that has none gets as its description.
std::string description_of(const MapBuildArguments& arguments) {
  return "from " + std::filesystem::path(arguments.log).filename().string();
}

Result<client::MapGrowth> build_over_http(const MapBuildArguments& arguments,
                                          evaluation::MappingScans& scans) {
  Result<client::ServerConnection> server = client::ServerConnection::open(arguments.connection);
  if (!server) return server.error();
  client::MapUpload upload(arguments.name, scans.log().header(), *server);
  const Result<void> described = upload.describe(description_of(arguments));
  if (!described) return described.error();
  const auto add = [&](std::span<const evaluation::LogScan> batch) {
    return upload.add(batch, arguments.scans.without_poses);
  };
  if (server->is_printing()) return add_in_batches(scans, add, nullptr);
  Progress progress("mapping");
  Result<client::MapGrowth> growth = add_in_batches(scans, add, &progress);
  if (!growth || !arguments.scans.without_poses) return growth;
  const Result<std::size_t> features = upload.count_features();
  if (!features) return features.error();
  growth->features = *features;
  return growth;
}

/// What the request checks over HTTP is checked here as well.
Result<void> describe_map(server::MapLibrary& library, const MapBuildArguments& arguments,
                          const evaluation::LogHeader& header) {
  const auto map = library.find(arguments.name);
  if (!map && map.error().code != ErrorCode::kNotFound) return map.error();
  std::optional<client::KnownOfMap> known;
  if (map) known = {!map->description.empty(), !map->lidar_json.empty(), map->has_floor_map};
  const auto body = client::description_body(description_of(arguments), header, known);
  if (!body) return {};
  const auto request = api::parse_put_map(*body, api::BodyFormat::kJson);
  if (const auto* problem = std::get_if<api::Problem>(&request)) {
    return Error{ErrorCode::kInvalidArgument, problem->detail, arguments.log};
  }
  const Result<bool> put = library.put(arguments.name, std::get<api::PutMapRequest>(request));
  if (!put) return put.error();
  return {};
}

Result<client::MapGrowth> growth_of(const Result<server::MapGrowthReport>& report) {
  if (!report) return report.error();
  return client::MapGrowth{report->accepted, report->duplicates, report->key_frames,
                           report->features, report->revision};
}

Result<client::MapGrowth> build_into_file(const MapBuildArguments& arguments,
                                          evaluation::MappingScans& scans) {
  const auto stores = server::StoreAccess::open(arguments.database);
  if (!stores) return stores.error();
  server::MapLibrary library(*stores, {}, server::now_text);
  const Result<void> described = describe_map(library, arguments, scans.log().header());
  if (!described) return described.error();
  Progress progress("mapping");
  Result<client::MapGrowth> growth = add_in_batches(
      scans,
      [&](std::span<const evaluation::LogScan> batch) {
        return growth_of(arguments.scans.without_poses
                             ? library.grow(arguments.name, client::robot_scans_as_sent(batch))
                             : library.grow(arguments.name, client::posed_scans_as_sent(batch)));
      },
      &progress);
  if (!growth) return growth;
  std::optional<Progress> optimizing;
  if (arguments.scans.without_poses) optimizing.emplace("optimizing");
  // Stores the features and the grid as well.
  const auto ready = library.load(arguments.name, [&](double share) {
    if (optimizing) optimizing->update(share);
    return true;
  });
  if (!ready) return ready.error();
  growth->features = (*ready)->features().size();
  return growth;
}

Result<evaluation::MappingScans> open_mapping_scans(const MapBuildArguments& arguments) {
  Progress progress("reading");
  return evaluation::MappingScans::open(arguments.log, arguments.scans,
                                        [&](double share) { progress.update(share); });
}

int run_map_build(const MapBuildArguments& arguments) {
  Result<evaluation::MappingScans> scans = open_mapping_scans(arguments);
  if (!scans) return fail(scans.error());
  const Result<client::MapGrowth> growth = arguments.database.empty()
                                               ? build_over_http(arguments, *scans)
                                               : build_into_file(arguments, *scans);
  if (!growth) return fail(growth.error());
  warn(arguments.log, scans->remarks());
  if (arguments.connection.print_curl) return kDone;
  if (growth->accepted == 0) {
    warn(arguments.log, kNothingNew);
  } else if (growth->duplicates > 0) {
    warn(arguments.log, std::to_string(growth->duplicates) + kPartlyKnown);
  }
  std::printf("%s: %zu scans (%zu there already), %zu keyframes, %zu features, revision %llu\n",
              arguments.name.c_str(), scans->count(), growth->duplicates, growth->keyframes,
              growth->features, static_cast<unsigned long long>(growth->revision));
  return kDone;
}

}  // namespace

void add_map_build_command(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<MapBuildArguments>();
  CLI::App* command = map.add_subcommand("build", "Make a map from a log, or update a map by it");
  command->footer(
      "A log is JSON lines (.jsonl) or CARMEN (.log, .clf, .gfs), also with .gz, or a bag of ROS\n"
      "1 or 2 (.bag, .mcap, .db3). Its poses must be corrected ones: in CARMEN logs those of the\n"
      "laser, in bags those of tf in the frame map. If a log marks key scans, only those make the\n"
      "map. With --slam all scans do, and their poses are found. Scans that the map holds already\n"
      "are skipped, so the same log may be sent again. A later run in the map's building and "
      "frame\n"
      "updates it: what is gone from the area that this run saw leaves the map.");
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
  add_connection_options(*command, arguments->connection);
  add_database_option(*command, arguments->database);
  command->callback([arguments, &exit_code] { exit_code = run_map_build(*arguments); });
}

}  // namespace cornerfix::cli

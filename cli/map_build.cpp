#include "cli/map_build.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "api/requests.hpp"
#include "cli/command.hpp"
#include "cli/progress.hpp"
#include "clients/cpp/scan_json.hpp"
#include "server/map_library.hpp"
#include "server/store_access.hpp"

namespace cornerfix::cli {

namespace {

constexpr std::size_t kScansPerBatch = 50;
const std::string kNothingNew =
    "the map holds scans of all its stamps already: nothing was added. Another drive needs stamps "
    "of its own";
const std::string kPartlyKnown =
    " of its scans have stamps that the map holds already and were left out, as after an "
    "interruption. Another drive needs stamps of its own";

std::string file_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

/// What a batch added, and where the map stands after it.
using Growth = server::MapGrowthReport;
using AddBatch = std::function<Result<Growth>(std::span<const evaluation::LogScan>)>;

std::vector<evaluation::LogScan> next_batch(evaluation::MappingScans& scans) {
  std::vector<evaluation::LogScan> batch;
  while (batch.size() < kScansPerBatch) {
    std::optional<evaluation::LogScan> scan = scans.next();
    if (!scan) break;
    batch.push_back(std::move(*scan));
  }
  return batch;
}

/// Adds all scans, a batch after the other. Returns where the map stands in the end.
Result<Growth> add_in_batches(evaluation::MappingScans& scans, const AddBatch& add,
                              Progress* progress) {
  Growth total;
  for (auto batch = next_batch(scans); !batch.empty(); batch = next_batch(scans)) {
    Result<Growth> growth = add(batch);
    if (!growth) return growth;
    growth->accepted += total.accepted;
    growth->duplicates += total.duplicates;
    total = *growth;
    if (progress != nullptr) progress->update(scans.progress());
  }
  return total;
}

/// The description and lidar that a map has already. A later run does not change them, and a run
/// into an occupancy map will be refused.
struct KnownOfMap {
  bool description = false;
  bool lidar = false;
  bool is_floor_map = false;
};

/// Description and lidar from the log, as far as the map has none; nothing when it has both.
std::optional<std::string> description_body(const MapBuildArguments& arguments,
                                            const evaluation::LogHeader& header,
                                            const std::optional<KnownOfMap>& known) {
  nlohmann::ordered_json body;
  if (known && known->is_floor_map) return std::nullopt;
  if (!known || !known->description) body["description"] = "from " + file_name(arguments.log);
  if (!known || !known->lidar) body["lidar"] = client::lidar_json(header);
  if (body.empty()) return std::nullopt;
  return body.dump();
}

// --- over HTTP ----------------------------------------------------------------------------------

client::HttpRequest batch_request(const std::string& map, const evaluation::LogHeader& header,
                                  std::span<const evaluation::LogScan> scans, bool without_poses) {
  auto list = nlohmann::ordered_json::array();
  for (const evaluation::LogScan& scan : scans)
    list.push_back(without_poses ? client::robot_scan_json(header, scan, true)
                                 : client::posed_scan_json(header, scan));
  const nlohmann::ordered_json body = {{"lidar", client::lidar_json(header)},
                                       {"scans", std::move(list)}};
  return {"POST", "/v1/maps/" + client::percent_encode(map) + "/scans", body.dump()};
}

Growth growth_from_json(const nlohmann::json& answer) {
  if (!answer.is_object()) return {};  // Nothing was sent.
  return {.accepted = answer.value("accepted", std::size_t{0}),
          .duplicates = answer.value("duplicates", std::size_t{0}),
          .key_frames = answer.value("keyframes", std::size_t{0}),
          .features = answer.value("features", std::size_t{0}),
          .revision = answer.value("revision", std::uint64_t{0})};
}

/// Makes the map, or adds the description and lidar that it does not have.
Result<void> describe_map(ServerConnection& server, const MapBuildArguments& arguments,
                          const evaluation::LogHeader& header) {
  const std::string path = "/v1/maps/" + client::percent_encode(arguments.name);
  std::optional<KnownOfMap> known;
  if (!server.is_printing()) {
    const Result<nlohmann::json> map = server.call({"GET", path});
    if (!map && map.error().code != ErrorCode::kNotFound) return map.error();
    if (map)
      known = {!map->value("description", "").empty(),
               !map->value("lidar", nlohmann::json()).is_null(), map->value("floor_map", false)};
  }
  const auto body = description_body(arguments, header, known);
  if (!body) return {};
  const Result<nlohmann::json> described = server.call({"PUT", path, *body});
  if (!described) return described.error();
  return {};
}

Result<Growth> build_over_http(const MapBuildArguments& arguments,
                               evaluation::MappingScans& scans) {
  const evaluation::LogHeader& header = scans.log().header();
  Result<ServerConnection> server = ServerConnection::open(arguments.connection);
  if (!server) return server.error();
  const Result<void> described = describe_map(*server, arguments, header);
  if (!described) return described.error();
  const auto add = [&](std::span<const evaluation::LogScan> batch) -> Result<Growth> {
    const auto answer =
        server->call(batch_request(arguments.name, header, batch, arguments.scans.without_poses));
    if (!answer) return answer.error();
    return growth_from_json(*answer);
  };
  if (server->is_printing()) return add_in_batches(scans, add, nullptr);
  Progress progress("mapping");
  Result<Growth> growth = add_in_batches(scans, add, &progress);
  if (!growth || !arguments.scans.without_poses) return growth;
  // The first request for the map optimises its trajectory.
  const Result<nlohmann::json> ready =
      server->call({"GET", "/v1/maps/" + client::percent_encode(arguments.name) + "/features"});
  if (!ready) return ready.error();
  growth->features = ready->value("features", nlohmann::json::array()).size();
  return growth;
}

// --- into a file --------------------------------------------------------------------------------

/// What the request checks over HTTP is checked here as well.
Result<void> describe_map(server::MapLibrary& library, const MapBuildArguments& arguments,
                          const evaluation::LogHeader& header) {
  const auto map = library.find(arguments.name);
  if (!map && map.error().code != ErrorCode::kNotFound) return map.error();
  std::optional<KnownOfMap> known;
  if (map) known = {!map->description.empty(), !map->lidar_json.empty(), map->has_floor_map};
  const auto body = description_body(arguments, header, known);
  if (!body) return {};
  const auto request = api::parse_put_map(*body, api::BodyFormat::kJson);
  if (const auto* problem = std::get_if<api::Problem>(&request)) {
    return Error{ErrorCode::kInvalidArgument, problem->detail, arguments.log};
  }
  const Result<bool> put = library.put(arguments.name, std::get<api::PutMapRequest>(request));
  if (!put) return put.error();
  return {};
}

std::vector<PosedScan> posed_scans(std::span<const evaluation::LogScan> scans) {
  std::vector<PosedScan> posed;
  posed.reserve(scans.size());
  for (const evaluation::LogScan& scan : scans)
    posed.push_back({client::as_sent(scan.scan), Pose2{}, *scan.T_map_laser});
  return posed;
}

std::vector<RobotScan> robot_scans(std::span<const evaluation::LogScan> scans) {
  std::vector<RobotScan> robot;
  robot.reserve(scans.size());
  for (const evaluation::LogScan& scan : scans)
    robot.push_back({client::as_sent(scan.scan), Pose2{}, scan.T_odom_laser});
  return robot;
}

Result<Growth> build_into_file(const MapBuildArguments& arguments,
                               evaluation::MappingScans& scans) {
  const auto stores = server::StoreAccess::open(arguments.database);
  if (!stores) return stores.error();
  server::MapLibrary library(*stores, {}, utc_now_text);
  const Result<void> described = describe_map(library, arguments, scans.log().header());
  if (!described) return described.error();
  Progress progress("mapping");
  Result<Growth> growth = add_in_batches(
      scans,
      [&](std::span<const evaluation::LogScan> batch) {
        return arguments.scans.without_poses ? library.grow(arguments.name, robot_scans(batch))
                                             : library.grow(arguments.name, posed_scans(batch));
      },
      &progress);
  if (!growth) return growth;
  std::optional<Progress> optimizing;
  if (arguments.scans.without_poses) optimizing.emplace("optimizing");
  // Stores the features and the grid as well.
  const auto ready = library.load(arguments.name, [&](double share) {
    if (optimizing) optimizing->update(share);
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

}  // namespace

int run_map_build(const MapBuildArguments& arguments) {
  Result<evaluation::MappingScans> scans = open_mapping_scans(arguments);
  if (!scans) return fail(scans.error());
  const Result<Growth> growth = arguments.database.empty() ? build_over_http(arguments, *scans)
                                                           : build_into_file(arguments, *scans);
  if (!growth) return fail(growth.error());
  warn(arguments.log, scans->remarks());
  if (arguments.connection.print_curl) return kDone;
  if (growth->accepted == 0) {
    warn(arguments.log, kNothingNew);
  } else if (growth->duplicates > 0) {
    warn(arguments.log, std::to_string(growth->duplicates) + kPartlyKnown);
  }
  std::printf("%s: %zu scans (%zu there already), %zu key frames, %zu features, revision %llu\n",
              arguments.name.c_str(), scans->count(), growth->duplicates, growth->key_frames,
              growth->features, static_cast<unsigned long long>(growth->revision));
  return kDone;
}

}  // namespace cornerfix::cli

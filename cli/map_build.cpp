#include "cli/map_build.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <utility>

#include "cli/command.hpp"
#include "cli/evaluation.hpp"
#include "cli/progress.hpp"
#include "cli/scan_json.hpp"

namespace cornerfix::cli {

namespace {

constexpr std::size_t kScansPerBatch = 50;

std::string file_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

struct Growth {
  std::size_t duplicates = 0;
  std::size_t key_frames = 0;
  std::size_t features = 0;
  std::size_t revision = 0;
};

HttpRequest describe_request(const MapBuildArguments& arguments, const LogHeader& header) {
  const nlohmann::ordered_json body = {{"description", "from " + file_name(arguments.log)},
                                       {"lidar", lidar_json(header)}};
  return {"PUT", "/v1/maps/" + percent_encode(arguments.name), body.dump()};
}

HttpRequest batch_request(const std::string& map, const LogHeader& header,
                          std::span<const LogScan> scans) {
  auto list = nlohmann::ordered_json::array();
  for (const LogScan& scan : scans) list.push_back(posed_scan_json(scan));
  const nlohmann::ordered_json body = {{"lidar", lidar_json(header)}, {"scans", std::move(list)}};
  return {"POST", "/v1/maps/" + percent_encode(map) + "/scans", body.dump()};
}

Result<Growth> build_over_http(const MapBuildArguments& arguments, const LogHeader& header,
                               std::span<const LogScan> scans) {
  Result<ServerConnection> server = ServerConnection::open(arguments.connection);
  if (!server) return server.error();
  const Result<nlohmann::json> described = server->call(describe_request(arguments, header));
  if (!described) return described.error();
  Growth growth;
  Progress progress("mapping");
  for (std::size_t at = 0; at < scans.size(); at += kScansPerBatch) {
    const auto batch = scans.subspan(at, std::min(kScansPerBatch, scans.size() - at));
    const auto answer = server->call(batch_request(arguments.name, header, batch));
    if (!answer) return answer.error();
    if (server->is_printing()) continue;
    growth.duplicates += answer->value("duplicates", std::size_t{0});
    growth.key_frames = answer->value("keyframes", std::size_t{0});
    growth.features = answer->value("features", std::size_t{0});
    growth.revision = answer->value("revision", std::size_t{0});
    progress.update(static_cast<double>(at + batch.size()) / static_cast<double>(scans.size()));
  }
  return growth;
}

}  // namespace

std::vector<LogScan> mapping_scans(RecordedLog log, double split) {
  log.scans.resize(split_index(log, split));
  const bool marks_key_scans = std::any_of(log.scans.begin(), log.scans.end(),
                                           [](const LogScan& scan) { return scan.is_key_scan; });
  std::erase_if(log.scans, [&](const LogScan& scan) {
    return !scan.T_map_laser || (marks_key_scans && !scan.is_key_scan);
  });
  return std::move(log.scans);
}

int run_map_build(const MapBuildArguments& arguments) {
  Result<RecordedLog> log = read_log(arguments.log, arguments.stride);
  if (!log) return fail(log.error());
  const LogHeader header = log->header;
  const std::vector<LogScan> scans = mapping_scans(std::move(*log), arguments.split);
  if (scans.empty()) {
    return fail({ErrorCode::kInvalidArgument, "holds no scan with a pose", arguments.log});
  }
  const Result<Growth> growth = build_over_http(arguments, header, scans);
  if (!growth) return fail(growth.error());
  if (arguments.connection.print_curl) return kDone;
  std::printf("%s: %zu scans (%zu there already), %zu key frames, %zu features, revision %zu\n",
              arguments.name.c_str(), scans.size(), growth->duplicates, growth->key_frames,
              growth->features, growth->revision);
  return kDone;
}

}  // namespace cornerfix::cli

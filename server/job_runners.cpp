#include "server/job_runners.hpp"

#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "api/json_codec.hpp"
#include "api/report_codec.hpp"
#include "server/map_entries.hpp"
#include "server/media_types.hpp"
#include "storage/map_archive.hpp"

namespace cornerfix::server {
namespace {

/// Between looks at a report that is being made.
constexpr std::chrono::seconds kLookInterval{1};

Error incomplete_input() {
  return {ErrorCode::kCorruptData, "the job's input is incomplete", "job"};
}

std::string_view text_in(const storage::Blob& blob) {
  return {reinterpret_cast<const char*>(blob.data()), blob.size()};
}

Result<std::string> import_floor_map(MapLibrary& maps, const JobTask& task) {
  const auto yaml = task.input.find("yaml");
  const auto image = task.input.find("image");
  if (yaml == task.input.end() || image == task.input.end()) return incomplete_input();
  const auto report =
      maps.put_floor_map(task.map, text_in(yaml->second), std::as_bytes(std::span(image->second)),
                         task.progress, task.known_map);
  if (!report) return report.error();
  return api::encode(api::render_floor_map(entry_of(*report)), api::BodyFormat::kJson);
}

Error input_error(const api::Problem& problem) {
  const bool has_place = !problem.errors.empty();
  return {ErrorCode::kInvalidArgument, problem.detail,
          has_place ? problem.errors.front().pointer : std::string()};
}

Result<std::string> map_run(MapLibrary& maps, const api::RequestLimits& limits,
                            const JobTask& task) {
  const auto run = task.input.find("run");
  const auto type = task.input.find("type");
  if (run == task.input.end() || type == task.input.end()) return incomplete_input();
  const auto format = format_of_content_type(text_in(type->second));
  if (!format) return incomplete_input();
  const auto info = maps.find(task.map);
  if (!info) return info.error();
  const auto parsed = api::parse_map_scans(text_in(run->second), *format,
                                           api::lidar_from_json(info->lidar_json), limits);
  if (const auto* problem = std::get_if<api::Problem>(&parsed)) return input_error(*problem);
  const auto& scans = std::get<api::MapScansRequest>(parsed);
  const auto report =
      scans.unposed_scans.empty()
          ? maps.add_run(task.map, scans.scans, task.progress, task.known_map)
          : maps.add_run(task.map, scans.unposed_scans, task.progress, task.known_map);
  if (!report) return report.error();
  return api::encode(api::render_map_batch(entry_of(*report)), api::BodyFormat::kJson);
}

/// The map that an earlier attempt made of the archive before its server ended; else nothing.
std::optional<storage::MapInfo> restored_before(MapLibrary& maps, const JobTask& task,
                                                const storage::Blob& bytes) {
  if (task.known_map.revision > 0) return std::nullopt;  // It was there before the job.
  const auto archive = storage::decode_archive(bytes);
  auto info = maps.find(task.map);
  const bool is_same =
      archive && info && info->digest == archive->digest && info->revision == archive->revision;
  return is_same ? std::optional(std::move(*info)) : std::nullopt;
}

Result<std::string> restore_map(MapLibrary& maps, const JobTask& task) {
  const auto archive = task.input.find("archive");
  if (archive == task.input.end()) return incomplete_input();
  auto info = maps.restore(task.map, archive->second, task.progress);
  if (!info && info.error().code == ErrorCode::kConflict) {
    if (auto before = restored_before(maps, task, archive->second)) info = std::move(*before);
  }
  if (!info) return info.error();
  return api::encode(api::render_map(entry_of(*info)), api::BodyFormat::kJson);
}

Result<std::string> report_on_map(MapLibrary& maps, ReportService& reports, const JobTask& task) {
  for (double share = 0.0;;) {
    if (!task.progress("simulation", share))
      return Error{ErrorCode::kUnavailable, "the report was given up", ""};
    const auto info = maps.find(task.map);
    if (!info) return info.error();
    if (task.known_map.id != 0 && info->id != task.known_map.id) return lost_map(task.map);
    if (!info->bounds) return map_without_grid();
    const auto view = reports.get(*info, kLookInterval, ReportWaiter::kJob);
    if (!view) return view.error();
    if (view->report) {
      return api::encode(api::render_report({info->name, view->revision}, *view->report),
                         api::BodyFormat::kJson);
    }
    share = view->progress;
  }
}

}  // namespace

api::RequestLimits limits_of_runs(api::RequestLimits limits) {
  limits.max_scans = std::numeric_limits<std::size_t>::max();
  return limits;
}

JobRunners make_job_runners(const std::shared_ptr<MapLibrary>& maps,
                            const std::shared_ptr<ReportService>& reports,
                            const api::RequestLimits& limits) {
  return {{kImportJob, [maps](const JobTask& task) { return import_floor_map(*maps, task); }},
          {kMappingJob, [maps, limits = limits_of_runs(limits)](
                            const JobTask& task) { return map_run(*maps, limits, task); }},
          {kRestoreJob, [maps](const JobTask& task) { return restore_map(*maps, task); }},
          {kReportJob,
           [maps, reports](const JobTask& task) { return report_on_map(*maps, *reports, task); }}};
}

}  // namespace cornerfix::server

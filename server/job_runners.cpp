#include "server/job_runners.hpp"

#include <chrono>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "api/json_codec.hpp"
#include "api/report_codec.hpp"
#include "server/map_entries.hpp"

namespace cornerfix::server {
namespace {

/// Between looks at a report that is being made.
constexpr std::chrono::seconds kLookInterval{1};

Error incomplete_input() {
  return {ErrorCode::kCorruptData, "the job's input is incomplete", "job"};
}

Result<std::string> import_floor_map(MapLibrary& maps, const JobTask& task) {
  const auto yaml = task.input.find("yaml");
  const auto image = task.input.find("image");
  if (yaml == task.input.end() || image == task.input.end()) return incomplete_input();
  const std::string text(yaml->second.begin(), yaml->second.end());
  const auto report =
      maps.put_floor_map(task.map, text, std::as_bytes(std::span(image->second)), task.progress);
  if (!report) return report.error();
  return api::encode(api::render_floor_map(entry_of(*report)), api::BodyFormat::kJson);
}

Result<std::string> report_on_map(MapLibrary& maps, ReportService& reports, const JobTask& task) {
  for (double share = 0.0;;) {
    if (!task.progress("simulation", share))
      return Error{ErrorCode::kUnavailable, "the report was given up", ""};
    const auto info = maps.find(task.map);
    if (!info) return info.error();
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

JobRunners make_job_runners(const std::shared_ptr<MapLibrary>& maps,
                            const std::shared_ptr<ReportService>& reports) {
  return {{kImportJob, [maps](const JobTask& task) { return import_floor_map(*maps, task); }},
          {kReportJob,
           [maps, reports](const JobTask& task) { return report_on_map(*maps, *reports, task); }}};
}

}  // namespace cornerfix::server

/// \file  What the jobs of each kind do.
#pragma once

#include <array>
#include <memory>

#include "api/requests.hpp"
#include "server/job_service.hpp"
#include "server/map_library.hpp"
#include "server/report_service.hpp"

namespace cornerfix::server {

/// The kinds of jobs. An import has the input "yaml" and "image", a mapping the "run" and its media
/// "type", a restoration the "archive"; a report has none.
inline constexpr const char* kImportJob = "import";
inline constexpr const char* kMappingJob = "mapping";
inline constexpr const char* kReportJob = "report";
inline constexpr const char* kRestoreJob = "restore";
inline constexpr std::array kJobKinds = {kImportJob, kMappingJob, kReportJob, kRestoreJob};

/// The answers are those of PUT /v1/maps/{map}/grid, POST /v1/maps/{map}/scans,
/// GET /v1/maps/{map}/report and POST /v1/maps/{map}/archive.
[[nodiscard]] JobRunners make_job_runners(const std::shared_ptr<MapLibrary>& maps,
                                          const std::shared_ptr<ReportService>& reports,
                                          const api::RequestLimits& limits);

/// A run may have any number of scans, up to the values that a document may have.
[[nodiscard]] api::RequestLimits limits_of_runs(api::RequestLimits limits);

}  // namespace cornerfix::server

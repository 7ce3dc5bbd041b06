/// \file  What the jobs of each kind do.
#pragma once

#include <memory>

#include "server/job_service.hpp"
#include "server/map_library.hpp"
#include "server/report_service.hpp"

namespace cornerfix::server {

/// The kinds of jobs. An import has the input "yaml" and "image"; a report has none.
inline constexpr const char* kImportJob = "import";
inline constexpr const char* kReportJob = "report";

/// The answers are those of PUT /v1/maps/{map}/grid and GET /v1/maps/{map}/report.
[[nodiscard]] JobRunners make_job_runners(const std::shared_ptr<MapLibrary>& maps,
                                          const std::shared_ptr<ReportService>& reports);

}  // namespace cornerfix::server

/// \file  What SLAM over a recorded run found, against the reference poses and the scans
/// themselves.
#pragma once

#include <nlohmann/json.hpp>

#include "evaluation/datasets/log_reader.hpp"
#include "evaluation/metrics/slam_run.hpp"

namespace cornerfix::evaluation {

/// Errors of relative poses over 2 m and 20 m of path, and those over pairs of scans of one place.
/// `run` is over the scans of `log`.
[[nodiscard]] nlohmann::ordered_json slam_report_json(const RecordedLog& log, const SlamRun& run,
                                                      double cpu_seconds);

}  // namespace cornerfix::evaluation

/// \file  What an evaluation needs before robots are started: a run, the maps to search, and the
/// scans that ask.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <cornerfix/result.hpp>

#include "evaluation/datasets/log_split.hpp"
#include "evaluation/metrics/localization_score.hpp"

namespace cornerfix::evaluation {

/// Where the maps come from.
struct EvaluationSources {
  std::string log;                       ///< Its scans ask.
  std::string map_log;                   ///< Makes the map; if empty, a part of `log` does.
  std::string other_map_log;             ///< Makes it, too, but is of another building.
  std::string map_grid;                  ///< Occupancy map that is the map; empty for none.
  std::vector<std::string> update_logs;  ///< Of later runs in map_log's building.
  std::vector<std::string>
      further_maps;           ///< Logs or occupancy maps, searched beside the right map.
  std::string split = "0.5";  ///< How `log` is divided, as parse_log_split() reads it.
  bool slam = false;          ///< Make maps without the poses of their logs.

  /// The log that makes the map; empty when a part of `log` does.
  [[nodiscard]] const std::string& mapping_log() const {
    return other_map_log.empty() ? map_log : other_map_log;
  }
};

/// How a task reads logs, and where it reports how far it is.
struct TaskEnvironment {
  std::function<Result<RecordedLog>(const std::string& path)> read_log;
  /// Called when a phase of long work begins ("slam", "mapping"). Returns what is called with the
  /// share done, in [0, 1], until the phase ends.
  std::function<std::function<void(double)>(const std::string& phase)> begin_phase;
};

struct EvaluationTask {
  RecordedLog log;
  std::vector<std::size_t> asking;       ///< Indices of the scans that ask.
  Evaluation evaluation;                 ///< With the right map.
  std::vector<LocalizationMapPtr> maps;  ///< The right one first.
  /// Index in `maps`, or kNoMap if the log is of another building: every answer is wrong then.
  std::size_t right_map = 0;
  std::vector<Point2> mapping_positions;  ///< Empty if the log is of another building.

  /// The map that holds the run; null if none does.
  [[nodiscard]] const LocalizationMap* true_map() const {
    return right_map == kNoMap ? nullptr : maps[right_map].get();
  }
};

/// Reads the logs and makes the maps. An error as well when no scan maps or none asks. `split` is
/// that of the sources.
[[nodiscard]] Result<EvaluationTask> prepare_task(const EvaluationSources& sources,
                                                  const LogSplit& split,
                                                  const EvaluationOptions& options,
                                                  const TaskEnvironment& environment);

}  // namespace cornerfix::evaluation

#include "evaluation/metrics/evaluation_task.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <span>
#include <utility>

#include "evaluation/metrics/slam_run.hpp"
#include "evaluation/metrics/trajectory_score.hpp"

namespace cornerfix::evaluation {

namespace {

/// All scans of a log that can make a map marked as key scans, or only those that it marks itself.
void mark_key_scans(RecordedLog& log) {
  const bool are_marked = std::ranges::any_of(log.scans, &LogScan::is_key_scan);
  for (LogScan& scan : log.scans) scan.is_key_scan = !are_marked || scan.is_key_scan;
}

class MapMaker {
 public:
  MapMaker(const EvaluationSources& sources, const EvaluationOptions& options,
           const TaskEnvironment& environment)
      : sources_(sources), options_(options), environment_(environment) {}

  /// The map of the scans with these indices, one at least; with SLAM, of all scans up to the last
  /// of them.
  [[nodiscard]] Result<Evaluation> map_of(const RecordedLog& log,
                                          std::span<const std::size_t> mapping) const {
    if (!sources_.slam) return map_at_poses(log, mapping);
    const std::size_t end = mapping.back() + 1;
    const Result<RecordedLog> found = with_slam_poses(log, end);
    if (!found) return found.error();
    return map_at_poses(*found, posed_scans(*found, 0, end));
  }

  /// The map of the mapping log, updated by the later runs.
  [[nodiscard]] Result<Evaluation> map_of_runs() const {
    const Result<RecordedLog> log = read_runs();
    if (!log) return log.error();
    return map_of_all(*log, sources_.mapping_log());
  }

  /// A map to search beside the right one: of all of a log, or of an occupancy map.
  [[nodiscard]] Result<Evaluation> further_map(const std::string& path) const {
    if (std::filesystem::path(path).extension() == ".yaml") {
      RecordedLog nowhere;
      nowhere.header.name = path;
      return map_from_occupancy_map(path, nowhere, options_.mapper);
    }
    const Result<RecordedLog> log = environment_.read_log(path);
    if (!log) return log.error();
    return map_of_all(*log, path);
  }

 private:
  [[nodiscard]] Evaluation map_at_poses(const RecordedLog& log,
                                        std::span<const std::size_t> mapping) const {
    const auto progress = environment_.begin_phase("mapping");
    return map_from(log, mapping, options_.mapper, [&](std::size_t done, std::size_t all) {
      progress(static_cast<double>(done) / static_cast<double>(all));
    });
  }

  [[nodiscard]] Result<Evaluation> map_of_all(const RecordedLog& log,
                                              const std::string& path) const {
    const auto mapping = posed_scans(log, 0, log.scans.size());
    if (mapping.empty())
      return Error{ErrorCode::kInvalidArgument, "holds no scan with a pose", path};
    return map_of(log, mapping);
  }

  /// The first scans of a log. SLAM's keyframes have SLAM's poses, moved as a whole to lie as near
  /// as possible to the reference poses.
  [[nodiscard]] Result<RecordedLog> with_slam_poses(const RecordedLog& log, std::size_t end) const {
    RecordedLog posed{log.header,
                      {log.scans.begin(), log.scans.begin() + static_cast<std::ptrdiff_t>(end)}};
    const Result<SlamRun> run = run_slam(posed.scans, options_.use_odometry, options_.mapper,
                                         environment_.begin_phase("slam"));
    if (!run) return run.error();
    const Pose2 T_map_slam = align_to_reference(posed.scans, run->T_map_laser);
    for (LogScan& scan : posed.scans) {
      scan.T_map_laser.reset();
      scan.is_key_scan = false;
    }
    for (const std::size_t i : run->key_scans) {
      posed.scans[i].T_map_laser = T_map_slam * run->T_map_laser[i];
      posed.scans[i].is_key_scan = true;
    }
    return posed;
  }

  /// The mapping log and those of later runs, as one.
  [[nodiscard]] Result<RecordedLog> read_runs() const {
    Result<RecordedLog> log = environment_.read_log(sources_.mapping_log());
    if (!log || sources_.update_logs.empty()) return log;
    mark_key_scans(*log);
    for (const std::string& path : sources_.update_logs) {
      Result<RecordedLog> later = environment_.read_log(path);
      if (!later) return later.error();
      mark_key_scans(*later);
      std::ranges::move(later->scans, std::back_inserter(log->scans));
    }
    return log;
  }

  const EvaluationSources& sources_;
  const EvaluationOptions& options_;
  const TaskEnvironment& environment_;
};

/// The map of one part of the log; the other part asks.
Result<Evaluation> map_of_part(const EvaluationSources& sources, const LogSplit& split,
                               const MapMaker& maker, EvaluationTask& task) {
  DividedLog divided = divide(task.log, split);
  if (divided.mapping.empty()) {
    return Error{ErrorCode::kInvalidArgument, "holds no scan with a pose in the part that maps",
                 sources.log};
  }
  Result<Evaluation> made = maker.map_of(task.log, divided.mapping);
  if (!made) return made;
  task.asking = std::move(divided.asking);
  made->split = sources.split;
  return made;
}

Result<Evaluation> right_map(const EvaluationSources& sources, const LogSplit& split,
                             const EvaluationOptions& options, const MapMaker& maker,
                             EvaluationTask& task) {
  if (sources.map_grid.empty() && sources.mapping_log().empty())
    return map_of_part(sources, split, maker, task);
  task.asking = posed_scans(task.log, 0, task.log.scans.size());
  if (sources.map_grid.empty()) return maker.map_of_runs();
  return map_from_occupancy_map(sources.map_grid, task.log, options.mapper);
}

}  // namespace

Result<EvaluationTask> prepare_task(const EvaluationSources& sources, const LogSplit& split,
                                    const EvaluationOptions& options,
                                    const TaskEnvironment& environment) {
  const MapMaker maker(sources, options, environment);
  Result<RecordedLog> log = environment.read_log(sources.log);
  if (!log) return log.error();
  EvaluationTask task;
  task.log = std::move(*log);
  Result<Evaluation> made = right_map(sources, split, options, maker, task);
  if (!made) return made.error();
  task.evaluation = std::move(*made);
  if (task.asking.empty()) {
    return Error{ErrorCode::kInvalidArgument, "holds no scan with a pose in the part that asks",
                 sources.log};
  }
  task.maps.push_back(task.evaluation.map);
  for (const std::string& path : sources.further_maps) {
    const Result<Evaluation> further = maker.further_map(path);
    if (!further) return further.error();
    task.maps.push_back(further->map);
  }
  if (sources.other_map_log.empty()) {
    task.mapping_positions = task.evaluation.mapping_positions;
  } else {
    task.right_map = kNoMap;
  }
  return task;
}

}  // namespace cornerfix::evaluation

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "cli/command.hpp"
#include "cli/progress.hpp"
#include "cli/whole_log.hpp"
#include "evaluation/datasets/log_split.hpp"
#include "evaluation/metrics/evaluation_report.hpp"
#include "evaluation/metrics/explanation.hpp"
#include "evaluation/metrics/localization_score.hpp"
#include "evaluation/metrics/report_score.hpp"
#include "evaluation/metrics/single_scan.hpp"
#include "evaluation/metrics/slam_run.hpp"
#include "evaluation/metrics/trajectory_score.hpp"

namespace cornerfix::cli {

namespace {

struct EvaluateArguments {
  std::string log;
  evaluation::LogSelection selection;
  std::string map_log;
  std::string other_map_log;
  std::string map_grid;
  std::vector<std::string> update_logs;   ///< Of later runs in map_log's building.
  std::vector<std::string> further_maps;  ///< Searched beside the right map.
  std::string split = "0.5";
  std::size_t stride = 1;
  std::string method = std::string(to_string(LocalizerParams{}.method));
  std::string extractor = std::string(to_string(LocalizerParams{}.extractor));
  std::string out;
  std::string csv;
  std::string samples;
  bool no_odometry = false;
  bool slam = false;
  bool report = false;
  bool single_scan = false;
  std::optional<std::size_t> explained_start;
  std::string odometry_fault;
  evaluation::EvaluationOptions options;

  /// The log that makes the map; empty when a part of the log that asks does.
  [[nodiscard]] const std::string& mapping_log() const {
    return other_map_log.empty() ? map_log : other_map_log;
  }
};

/// Progress of work that counts what is done.
evaluation::ShareDone show_on(Progress& progress) {
  return [&progress](std::size_t done, std::size_t all) {
    progress.update(static_cast<double>(done) / static_cast<double>(all));
  };
}

/// The first scans of a log. SLAM's keyframes have SLAM's poses, moved as a whole to lie as near as
/// possible to the reference poses.
Result<evaluation::RecordedLog> with_slam_poses(const evaluation::RecordedLog& log, std::size_t end,
                                                const evaluation::EvaluationOptions& options) {
  evaluation::RecordedLog posed{
      log.header, {log.scans.begin(), log.scans.begin() + static_cast<std::ptrdiff_t>(end)}};
  Progress progress("slam");
  const Result<evaluation::SlamRun> run =
      evaluation::run_slam(posed.scans, options.use_odometry, options.mapper,
                           [&](double share) { progress.update(share); });
  if (!run) return run.error();
  const Pose2 T_map_slam = evaluation::align_to_reference(posed.scans, run->T_map_laser);
  for (evaluation::LogScan& scan : posed.scans) {
    scan.T_map_laser.reset();
    scan.is_key_scan = false;
  }
  for (const std::size_t i : run->key_scans) {
    posed.scans[i].T_map_laser = T_map_slam * run->T_map_laser[i];
    posed.scans[i].is_key_scan = true;
  }
  return posed;
}

evaluation::Evaluation map_at_poses(const evaluation::RecordedLog& log,
                                    std::span<const std::size_t> mapping,
                                    const MapperParams& params) {
  Progress progress("mapping");
  return evaluation::map_from(log, mapping, params, show_on(progress));
}

/// The map of the scans with these indices, one at least; with SLAM, of all scans up to the last of
/// them.
Result<evaluation::Evaluation> map_of(const evaluation::RecordedLog& log,
                                      std::span<const std::size_t> mapping,
                                      const EvaluateArguments& arguments) {
  const MapperParams& params = arguments.options.mapper;
  if (!arguments.slam) return map_at_poses(log, mapping, params);
  const std::size_t end = mapping.back() + 1;
  const Result<evaluation::RecordedLog> found = with_slam_poses(log, end, arguments.options);
  if (!found) return found.error();
  return map_at_poses(*found, evaluation::posed_scans(*found, 0, end), params);
}

/// All scans of a log that can make a map marked as key scans, or only those that it marks itself.
void mark_key_scans(evaluation::RecordedLog& log) {
  const bool are_marked = std::ranges::any_of(log.scans, &evaluation::LogScan::is_key_scan);
  for (evaluation::LogScan& scan : log.scans) scan.is_key_scan = !are_marked || scan.is_key_scan;
}

/// A log and those of later runs, as one.
Result<evaluation::RecordedLog> read_drives(const EvaluateArguments& arguments) {
  Result<evaluation::RecordedLog> log =
      read_whole_log(arguments.mapping_log(), arguments.selection, arguments.stride);
  if (!log || arguments.update_logs.empty()) return log;
  mark_key_scans(*log);
  for (const std::string& path : arguments.update_logs) {
    Result<evaluation::RecordedLog> later =
        read_whole_log(path, arguments.selection, arguments.stride);
    if (!later) return later.error();
    mark_key_scans(*later);
    std::ranges::move(later->scans, std::back_inserter(log->scans));
  }
  return log;
}

Result<evaluation::Evaluation> map_of_all(const evaluation::RecordedLog& log,
                                          const std::string& path,
                                          const EvaluateArguments& arguments) {
  const auto mapping = evaluation::posed_scans(log, 0, log.scans.size());
  if (mapping.empty()) {
    return Error{ErrorCode::kInvalidArgument, "holds no scan with a pose", path};
  }
  return map_of(log, mapping, arguments);
}

/// A map to search beside the right one: of all of a log, or of an occupancy map.
Result<evaluation::Evaluation> further_map(const std::string& path,
                                           const EvaluateArguments& arguments) {
  if (std::filesystem::path(path).extension() == ".yaml") {
    evaluation::RecordedLog nowhere;
    nowhere.header.name = path;
    return evaluation::map_from_floor_map(path, nowhere, arguments.options.mapper);
  }
  const Result<evaluation::RecordedLog> log =
      read_whole_log(path, arguments.selection, arguments.stride);
  if (!log) return log.error();
  return map_of_all(*log, path, arguments);
}

/// The map of the given log, updated by those of later runs.
Result<evaluation::Evaluation> map_of_drives(const EvaluateArguments& arguments) {
  const Result<evaluation::RecordedLog> log = read_drives(arguments);
  if (!log) return log.error();
  return map_of_all(*log, arguments.mapping_log(), arguments);
}

template <typename Write>
Result<void> write_file(const std::string& path, std::ios::openmode mode, const Write& write) {
  std::ofstream file(path, mode);
  write(file);
  if (!file.flush()) return Error{ErrorCode::kStorageFull, "could not be written", path};
  return {};
}

template <typename Record, typename RecordJson>
Result<void> write_out(const std::string& path, const nlohmann::ordered_json& summary,
                       const std::vector<Record>& records, const RecordJson& json_of) {
  nlohmann::ordered_json out{{"summary", summary}, {"starts", nlohmann::ordered_json::array()}};
  for (const Record& record : records) out["starts"].push_back(json_of(record));
  return write_file(path, std::ios::out, [&](std::ostream& file) { file << out << '\n'; });
}

/// Rows join those of earlier calls, so that one file gathers many logs.
Result<void> append_samples(const std::string& path, const std::string& name,
                            const std::vector<evaluation::StartRecord>& records) {
  return write_file(path, std::ios::app, [&](std::ofstream& csv) {
    evaluation::write_samples(csv, name, records, csv.tellp() == 0);
  });
}

std::string sample_name(const EvaluateArguments& arguments, const std::string& log) {
  if (!arguments.other_map_log.empty()) return "elsewhere:" + log;
  return (arguments.options.mirror ? "mirrored:" : "") + log;
}

/// Words of the command line that are no numbers.
void parse_words(EvaluateArguments& arguments) {
  evaluation::EvaluationOptions& options = arguments.options;
  const auto method = method_from_string(arguments.method);
  if (!method) throw CLI::ValidationError("--method", "unknown method " + arguments.method);
  options.localizer.method = *method;
  const auto extractor = corner_extractor_from_string(arguments.extractor);
  if (!extractor)
    throw CLI::ValidationError("--extractor", "unknown extractor " + arguments.extractor);
  options.mapper.extractor = options.localizer.extractor = *extractor;
  options.use_odometry = !arguments.no_odometry;
  options.odometry_fault = evaluation::odometry_fault_from_string(arguments.odometry_fault);
  options.sample = !arguments.samples.empty();
}

/// A log, the maps to ask it in, and the scans that ask.
struct Task {
  evaluation::RecordedLog log;
  std::vector<std::size_t> asking;
  evaluation::Evaluation evaluation;
  std::vector<LocalizationMapPtr> maps;  ///< The right one first.
};

Result<Task> prepare(const EvaluateArguments& arguments, const evaluation::LogSplit& split) {
  Result<evaluation::RecordedLog> log =
      read_whole_log(arguments.log, arguments.selection, arguments.stride);
  if (!log) return log.error();
  Task task{std::move(*log), {}, {}, {}};
  if (!arguments.map_grid.empty()) {
    Result<evaluation::Evaluation> made =
        evaluation::map_from_floor_map(arguments.map_grid, task.log, arguments.options.mapper);
    if (!made) return made.error();
    task.asking = evaluation::posed_scans(task.log, 0, task.log.scans.size());
    task.evaluation = std::move(*made);
  } else if (arguments.mapping_log().empty()) {
    evaluation::DividedLog divided = evaluation::divide(task.log, split);
    if (divided.mapping.empty()) {
      return Error{ErrorCode::kInvalidArgument, "holds no scan with a pose in the part that maps",
                   arguments.log};
    }
    Result<evaluation::Evaluation> mapped = map_of(task.log, divided.mapping, arguments);
    if (!mapped) return mapped.error();
    task.asking = std::move(divided.asking);
    task.evaluation = std::move(*mapped);
    task.evaluation.split = arguments.split;
  } else {
    Result<evaluation::Evaluation> mapped = map_of_drives(arguments);
    if (!mapped) return mapped.error();
    task.asking = evaluation::posed_scans(task.log, 0, task.log.scans.size());
    task.evaluation = std::move(*mapped);
  }
  if (task.asking.empty()) {
    return Error{ErrorCode::kInvalidArgument, "holds no scan with a pose in the part that asks",
                 arguments.log};
  }
  task.maps.push_back(task.evaluation.map);
  for (const std::string& path : arguments.further_maps) {
    const Result<evaluation::Evaluation> further = further_map(path, arguments);
    if (!further) return further.error();
    task.maps.push_back(further->map);
  }
  return task;
}

/// Where and against what a task is asked.
struct Reference {
  std::size_t right_map = 0;
  std::vector<Point2> mapping_positions;
};

/// In a building of its own no pose is near a mapped one and every answer is wrong.
Reference reference_of(const EvaluateArguments& arguments, const Task& task) {
  if (!arguments.other_map_log.empty()) return {evaluation::kNoMap, {}};
  return {0, task.evaluation.mapping_positions};
}

void run_starts(const EvaluateArguments& arguments, Task& task) {
  const Reference reference = reference_of(arguments, task);
  Progress progress("starts");
  const auto begin = std::chrono::steady_clock::now();
  task.evaluation.records =
      evaluation::evaluate(task.log, task.asking, task.maps, reference.right_map,
                           reference.mapping_positions, arguments.options, show_on(progress));
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  task.evaluation.wall_s = wall.count();
  if (std::ranges::none_of(task.evaluation.records, &evaluation::StartRecord::counts)) {
    warn(arguments.log,
         "no start counts: none has the driving of --way or the time of --time ahead");
  }
}

int run_single_scans(const EvaluateArguments& arguments, const Task& task) {
  const Reference reference = reference_of(arguments, task);
  std::vector<evaluation::SingleScanRecord> records;
  {
    Progress progress("scans");
    records = evaluation::evaluate_single_scans(task.log, task.asking, task.maps,
                                                reference.right_map, reference.mapping_positions,
                                                arguments.options, show_on(progress));
  }
  const nlohmann::ordered_json summary =
      evaluation::single_scan_summary_json(task.log.header.name, records, arguments.options.near_m);
  std::printf("%s\n", summary.dump(1).c_str());
  if (arguments.out.empty()) return kDone;
  const Result<void> written = write_out(arguments.out, summary, records, single_scan_record_json);
  return written ? kDone : fail(written.error());
}

/// DIR/start_N.json and DIR/start_N.png.
Result<void> write_explanation(const std::filesystem::path& directory,
                               const evaluation::Explanation& explanation,
                               const LocalizationMap* right_map) {
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  const std::string stem =
      (directory / ("start_" + std::to_string(explanation.record.start))).string();
  const nlohmann::ordered_json json = evaluation::explanation_json(explanation, right_map);
  Result<void> written = write_file(stem + ".json", std::ios::out,
                                    [&](std::ostream& file) { file << json.dump(1) << '\n'; });
  if (!written || !explanation.decision) return written;
  const std::string png = evaluation::draw_decision(*explanation.decision, right_map).encode();
  return write_file(stem + ".png", std::ios::out | std::ios::binary,
                    [&](std::ostream& file) { file << png; });
}

int run_explain(const EvaluateArguments& arguments, const Task& task) {
  const std::size_t start = *arguments.explained_start;
  if (std::ranges::find(task.asking, start) == task.asking.end()) {
    return fail({ErrorCode::kInvalidArgument,
                 "scan " + std::to_string(start) + " has no pose or does not ask", arguments.log});
  }
  const Reference reference = reference_of(arguments, task);
  const evaluation::Explanation explanation =
      evaluation::explain(task.log, task.asking, start, task.maps, reference.right_map,
                          reference.mapping_positions, arguments.options);
  const LocalizationMap* right_map =
      reference.right_map == evaluation::kNoMap ? nullptr : task.maps[reference.right_map].get();
  const Result<void> written = write_explanation(arguments.out, explanation, right_map);
  if (!written) return fail(written.error());
  std::printf("%s\n", evaluation::explanation_json(explanation, right_map).dump(1).c_str());
  return kDone;
}

Result<void> write_files(const EvaluateArguments& arguments, const nlohmann::ordered_json& summary,
                         const Task& task) {
  const std::vector<evaluation::StartRecord>& records = task.evaluation.records;
  Result<void> written;
  if (!arguments.out.empty()) written = write_out(arguments.out, summary, records, record_json);
  if (written && !arguments.csv.empty()) {
    written = write_file(arguments.csv, std::ios::out,
                         [&](std::ostream& csv) { evaluation::write_records(csv, records); });
  }
  if (written && !arguments.samples.empty()) {
    written =
        append_samples(arguments.samples, sample_name(arguments, task.log.header.name), records);
  }
  return written;
}

nlohmann::ordered_json report_json(const evaluation::ReportScore& score) {
  return {{"places", score.simulated_places},
          {"success", score.success},
          {"starts", score.starts},
          {"squares", score.squares},
          {"rank_correlation",
           {{"starts", score.over_starts},
            {"squares", score.over_squares},
            {"at_the_starts", score.at_the_starts}}}};
}

int run_evaluate(EvaluateArguments& arguments) {
  parse_words(arguments);
  const auto split = evaluation::parse_log_split(arguments.split);
  if (!split)
    throw CLI::ValidationError("--split", "expected a share from 0 to 1 or blocks:METRES");
  if (arguments.slam && std::holds_alternative<evaluation::BlockSplit>(*split))
    throw CLI::ValidationError("--slam", "needs a drive without gaps: --split with a share");
  Result<Task> task = prepare(arguments, *split);
  if (!task) return fail(task.error());
  if (arguments.single_scan) return run_single_scans(arguments, *task);
  if (arguments.explained_start) return run_explain(arguments, *task);
  run_starts(arguments, *task);
  nlohmann::ordered_json summary =
      evaluation::summary_json(task->log.header.name, task->evaluation, arguments.options);
  if (arguments.report)
    summary["report"] =
        report_json(evaluation::score_report(task->log, task->evaluation, arguments.options));
  std::printf("%s\n", summary.dump(1).c_str());
  const Result<void> written = write_files(arguments, summary, *task);
  return written ? kDone : fail(written.error());
}

void add_map_options(CLI::App& command, EvaluateArguments& arguments) {
  command.add_option(
      "--split", arguments.split,
      "Share of LOG that makes the map; or blocks:METRES, of which every other does");
  CLI::Option* map_log = command
                             .add_option("--map-log", arguments.map_log,
                                         "Log that makes the map, in LOG's frame; all of LOG asks")
                             ->check(CLI::ExistingFile);
  CLI::Option* update_logs =
      command
          .add_option("--update-log", arguments.update_logs,
                      "Log of a later drive in the building of --map-log, which updates the map")
          ->check(CLI::ExistingFile)
          ->allow_extra_args(false)
          ->needs(map_log);
  command
      .add_option("--elsewhere", arguments.other_map_log,
                  "Log of another building that makes the map: every answer is wrong")
      ->check(CLI::ExistingFile)
      ->excludes(map_log);
  command
      .add_option("--map-grid", arguments.map_grid,
                  "ROS floor map (yaml) that is the map, in LOG's frame; all of LOG asks")
      ->check(CLI::ExistingFile)
      ->excludes(map_log)
      ->excludes("--elsewhere");
  command
      .add_option("--any-map", arguments.further_maps,
                  "Logs or occupancy maps (yaml) of other buildings: look in these maps as well")
      ->check(CLI::ExistingFile);
  command
      .add_flag("--slam", arguments.slam,
                "Make maps without their logs' poses, which only say where a map lies")
      ->excludes("--map-grid")
      ->excludes(update_logs);
}

void add_start_options(CLI::App& command, evaluation::EvaluationOptions& options) {
  command.add_option("--starts", options.starts, "Robots switched on along LOG")
      ->check(above_zero());
  command
      .add_option("--near", options.near_m,
                  "Metres from a mapping pose: a start in the mapped part")
      ->check(not_below_zero());
  command
      .add_option("--way", options.way_m,
                  "Metres of driving allowed until localized; a start counts if LOG goes on as far")
      ->check(above_zero());
  command.add_option("--time", options.time_s, "Seconds of log time allowed until localized")
      ->check(above_zero());
  command
      .add_option("--track", options.track_m,
                  "Metres to follow after the first localized answer; each answer is judged")
      ->check(not_below_zero());
  command.add_option("--batch", options.batch, "Scans a question, 1 to 100")
      ->check(CLI::Range(1, 100));
  command.add_option("--threads", options.threads, "Robots at once, 1 to 256")
      ->check(CLI::Range(1, 256));
  command.add_flag("--mirror", options.mirror, "Turn the scans over: every answer is wrong");
}

void add_robot_options(CLI::App& command, EvaluateArguments& arguments) {
  command.add_option("--method", arguments.method,
                     "Where hypotheses come from: indexed, rma or nma");
  command.add_option("--extractor", arguments.extractor, "How corners are found: two_arm or vfp");
  CLI::Option* no_odometry =
      command.add_flag("--no-odom", arguments.no_odometry, "Ask without odometry");
  command
      .add_option("--odom-fault", arguments.odometry_fault,
                  "Corrupt the odometry that the robots report")
      ->check(CLI::IsMember(evaluation::odometry_fault_names()))
      ->excludes(no_odometry);
}

void add_output_options(CLI::App& command, EvaluateArguments& arguments) {
  CLI::Option* report =
      command.add_flag("--report", arguments.report,
                       "Make the map's localizability report and tell how well it predicts the way "
                       "to the fix (rank correlations)");
  CLI::Option* out = command.add_option("--out", arguments.out,
                                        "Write the figures and every start's record (JSON)");
  CLI::Option* csv = command.add_option("--csv", arguments.csv, "Write a row a start here");
  CLI::Option* samples = command.add_option(
      "--samples", arguments.samples,
      "Never accept; append what each search of the map knew here, for calibration");
  command
      .add_option("--explain", arguments.explained_start,
                  "Index of a start: write what the decision saw of the best pose and its rival to "
                  "the folder --out, as JSON and as a picture")
      ->needs(out)
      ->excludes(report)
      ->excludes(csv)
      ->excludes(samples);
  command
      .add_flag("--single-scan", arguments.single_scan,
                "One scan per robot, the best pose counts: correct within 0.5 m")
      ->excludes(report)
      ->excludes(csv)
      ->excludes(samples)
      ->excludes("--odom-fault")
      ->excludes("--explain");
}

}  // namespace

void add_evaluate_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<EvaluateArguments>();
  arguments->options.threads = std::max(1U, std::thread::hardware_concurrency());
  CLI::App* command = app.add_subcommand(
      "evaluate",
      "Score the localizer on a log with reference poses: one part maps, the rest asks");
  command->option_defaults()->always_capture_default();
  add_log(*command, arguments->log)->description("Log whose scans ask");
  add_selection(*command, arguments->selection);
  command->add_option("--stride", arguments->stride, "Use every n-th scan")->check(above_zero());
  add_map_options(*command, *arguments);
  add_start_options(*command, arguments->options);
  add_robot_options(*command, *arguments);
  add_output_options(*command, *arguments);
  command->callback([arguments, &exit_code] { exit_code = run_evaluate(*arguments); });
}

}  // namespace cornerfix::cli

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <variant>

#include "cli/command.hpp"
#include "cli/progress.hpp"
#include "evaluation/metrics/evaluation_files.hpp"
#include "evaluation/metrics/evaluation_report.hpp"
#include "evaluation/metrics/evaluation_task.hpp"
#include "evaluation/metrics/report_score.hpp"

namespace cornerfix::cli {

namespace {

using evaluation::EvaluationTask;

struct EvaluateArguments {
  evaluation::EvaluationSources sources;
  evaluation::LogSelection selection;
  std::size_t stride = 1;
  std::string method = std::string(to_string(LocalizerParams{}.method));
  std::string extractor = std::string(to_string(LocalizerParams{}.extractor));
  std::string out;
  std::string csv;
  std::string samples;
  bool no_odometry = false;
  bool report = false;
  bool single_scan = false;
  std::optional<std::size_t> explained_start;
  std::string odometry_fault;
  evaluation::EvaluationOptions options;
};

/// Progress of work that counts what is done.
evaluation::ShareDone show_on(Progress& progress) {
  return [&progress](std::size_t done, std::size_t all) {
    progress.update(static_cast<double>(done) / static_cast<double>(all));
  };
}

/// Logs are read with a bar and with warnings, phases have a bar each.
evaluation::TaskEnvironment environment_of(const EvaluateArguments& arguments) {
  return {.read_log =
              [&arguments](const std::string& path) {
                return read_whole_log(path, arguments.selection, arguments.stride);
              },
          .begin_phase = [](const std::string& phase) -> std::function<void(double)> {
            auto progress = std::make_shared<Progress>(phase);
            return [progress](double share) { progress->update(share); };
          }};
}

std::string sample_name(const EvaluateArguments& arguments, const std::string& log) {
  if (!arguments.sources.other_map_log.empty()) return "elsewhere:" + log;
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

evaluation::LogSplit split_of(const evaluation::EvaluationSources& sources) {
  const auto split = evaluation::parse_log_split(sources.split);
  if (!split)
    throw CLI::ValidationError("--split", "expected a share from 0 to 1 or blocks:METRES");
  if (sources.slam && std::holds_alternative<evaluation::BlockSplit>(*split))
    throw CLI::ValidationError("--slam", "needs a run without gaps: --split with a share");
  return *split;
}

void run_starts(const EvaluateArguments& arguments, EvaluationTask& task) {
  Progress progress("starts");
  const auto begin = std::chrono::steady_clock::now();
  task.evaluation.records =
      evaluation::evaluate(task.log, task.asking, task.maps, task.right_map, task.mapping_positions,
                           arguments.options, show_on(progress));
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  task.evaluation.wall_s = wall.count();
  if (std::ranges::none_of(task.evaluation.records, &evaluation::StartRecord::counts)) {
    warn(arguments.sources.log,
         "no start counts: none has the driving of --way or the time of --time ahead");
  }
}

int run_single_scans(const EvaluateArguments& arguments, const EvaluationTask& task) {
  std::vector<evaluation::SingleScanRecord> records;
  {
    Progress progress("scans");
    records = evaluation::evaluate_single_scans(task.log, task.asking, task.maps, task.right_map,
                                                task.mapping_positions, arguments.options,
                                                show_on(progress));
  }
  const nlohmann::ordered_json summary =
      evaluation::single_scan_summary_json(task.log.header.name, records, arguments.options.near_m);
  std::printf("%s\n", summary.dump(1).c_str());
  if (arguments.out.empty()) return kDone;
  const Result<void> written = evaluation::write_evaluation(arguments.out, summary, records);
  return written ? kDone : fail(written.error());
}

int run_explain(const EvaluateArguments& arguments, const EvaluationTask& task) {
  const std::size_t start = *arguments.explained_start;
  if (std::ranges::find(task.asking, start) == task.asking.end()) {
    return fail({ErrorCode::kInvalidArgument,
                 "scan " + std::to_string(start) + " has no pose or does not ask",
                 arguments.sources.log});
  }
  const evaluation::Explanation explanation =
      evaluation::explain(task.log, task.asking, start, task.maps, task.right_map,
                          task.mapping_positions, arguments.options);
  const Result<void> written =
      evaluation::write_explanation(arguments.out, explanation, task.true_map());
  if (!written) return fail(written.error());
  std::printf("%s\n", evaluation::explanation_json(explanation, task.true_map()).dump(1).c_str());
  return kDone;
}

Result<void> write_files(const EvaluateArguments& arguments, const nlohmann::ordered_json& summary,
                         const EvaluationTask& task) {
  const std::vector<evaluation::StartRecord>& records = task.evaluation.records;
  Result<void> written;
  if (!arguments.out.empty())
    written = evaluation::write_evaluation(arguments.out, summary, records);
  if (written && !arguments.csv.empty())
    written = evaluation::write_record_table(arguments.csv, records);
  if (written && !arguments.samples.empty()) {
    written = evaluation::append_samples(arguments.samples,
                                         sample_name(arguments, task.log.header.name), records);
  }
  return written;
}

int run_evaluate(EvaluateArguments& arguments) {
  parse_words(arguments);
  const evaluation::LogSplit split = split_of(arguments.sources);
  Result<EvaluationTask> task = evaluation::prepare_task(
      arguments.sources, split, arguments.options, environment_of(arguments));
  if (!task) return fail(task.error());
  if (arguments.single_scan) return run_single_scans(arguments, *task);
  if (arguments.explained_start) return run_explain(arguments, *task);
  run_starts(arguments, *task);
  nlohmann::ordered_json summary =
      evaluation::summary_json(task->log.header.name, task->evaluation, arguments.options);
  if (arguments.report) {
    summary["report"] = evaluation::report_score_json(
        evaluation::score_report(task->log, task->evaluation, arguments.options));
  }
  std::printf("%s\n", summary.dump(1).c_str());
  const Result<void> written = write_files(arguments, summary, *task);
  return written ? kDone : fail(written.error());
}

void add_map_options(CLI::App& command, evaluation::EvaluationSources& sources) {
  command.add_option(
      "--split", sources.split,
      "Share of LOG that makes the map; or blocks:METRES, of which every other does");
  CLI::Option* map_log = command
                             .add_option("--map-log", sources.map_log,
                                         "Log that makes the map, in LOG's frame; all of LOG asks")
                             ->check(CLI::ExistingFile);
  CLI::Option* update_logs =
      command
          .add_option("--update-log", sources.update_logs,
                      "Log of a later run in the building of --map-log, which updates the map")
          ->check(CLI::ExistingFile)
          ->allow_extra_args(false)
          ->needs(map_log);
  command
      .add_option("--elsewhere", sources.other_map_log,
                  "Log of another building that makes the map: every answer is wrong")
      ->check(CLI::ExistingFile)
      ->excludes(map_log);
  command
      .add_option("--map-grid", sources.map_grid,
                  "ROS occupancy map (yaml) that is the map, in LOG's frame; all of LOG asks")
      ->check(CLI::ExistingFile)
      ->excludes(map_log)
      ->excludes("--elsewhere");
  command
      .add_option("--any-map", sources.further_maps,
                  "Logs or occupancy maps (yaml) of other buildings: look in these maps as well")
      ->check(CLI::ExistingFile);
  command
      .add_flag("--slam", sources.slam,
                "Make maps without the poses of their logs, which only place a map")
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
      .add_option("--way", options.max_distance_m,
                  "Metres of driving allowed until localized; a start counts if LOG goes on as far")
      ->check(above_zero());
  command.add_option("--time", options.max_time_s, "Seconds of log time allowed until localized")
      ->check(above_zero());
  command
      .add_option("--track", options.track_m,
                  "Metres to follow after the first localized answer; each answer is judged")
      ->check(not_below_zero());
  command.add_option("--batch", options.batch, "Scans per question, 1 to 100")
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
                       "Make the map's localizability report and measure how well it predicts the "
                       "path length until localized (rank correlations)");
  CLI::Option* out = command.add_option("--out", arguments.out,
                                        "Write the figures and every start's record (JSON)");
  CLI::Option* csv = command.add_option("--csv", arguments.csv, "Write a row per start here");
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
  add_log(*command, arguments->sources.log)->description("Log whose scans ask");
  add_selection(*command, arguments->selection);
  command->add_option("--stride", arguments->stride, "Use every n-th scan")->check(above_zero());
  add_map_options(*command, arguments->sources);
  add_start_options(*command, arguments->options);
  add_robot_options(*command, *arguments);
  add_output_options(*command, *arguments);
  command->callback([arguments, &exit_code] { exit_code = run_evaluate(*arguments); });
}

}  // namespace cornerfix::cli

#include <cstdio>
#include <fstream>
#include <memory>
#include <thread>

#include "cli/command.hpp"
#include "cli/evaluation.hpp"
#include "cli/progress.hpp"
#include "cli/slam_run.hpp"
#include "cli/trajectory_score.hpp"

namespace cornerfix::cli {

namespace {

struct EvaluateArguments {
  std::string log;
  std::string map_log;
  std::string other_map_log;
  std::string method = std::string(to_string(LocalizerParams{}.method));
  std::string extractor = std::string(to_string(LocalizerParams{}.extractor));
  std::string csv;
  std::string samples;
  bool no_odometry = false;
  bool slam = false;
  EvaluationOptions options;
};

Result<void> write_records(const std::string& path, const std::vector<StartRecord>& records) {
  std::ofstream csv(path);
  csv << "start,near_m,verdict,way_m,seconds,driven_m,confidence,error_m,error_rad,x,y,yaw,true_x,"
         "true_y,true_yaw,"
         "scans,right_after,wrong_after\n";
  for (const StartRecord& record : records) {
    const char* verdict = record.verdict == Verdict::kFixed   ? "fixed"
                          : record.verdict == Verdict::kFalse ? "false"
                                                              : "none";
    csv << record.start << ',' << record.near_m << ',' << verdict << ',';
    if (record.way_m) csv << *record.way_m;
    csv << ',';
    if (record.seconds) csv << *record.seconds;
    csv << ',' << record.driven_m << ',' << record.confidence << ',' << record.error_m << ','
        << record.error_rad;
    for (const Pose2& pose : {record.pose, record.truth})
      csv << ',' << pose.x << ',' << pose.y << ',' << pose.yaw;
    csv << ',' << record.scans << ',' << record.right_after << ',' << record.wrong_after << '\n';
  }
  if (!csv.flush()) return Error{ErrorCode::kStorageFull, "could not be written", path};
  return {};
}

/// Rows join those of earlier calls, so that one file gathers many logs.
Result<void> append_samples(const std::string& path, const std::string& name,
                            const std::vector<StartRecord>& records) {
  std::ofstream csv(path, std::ios::app);
  write_samples(csv, name, records, csv.tellp() == 0);
  if (!csv.flush()) return Error{ErrorCode::kStorageFull, "could not be written", path};
  return {};
}

std::string sample_name(const EvaluateArguments& arguments, const std::string& log) {
  if (!arguments.other_map_log.empty()) return "elsewhere:" + log;
  return (arguments.options.mirror ? "mirrored:" : "") + log;
}

/// The first scans of a log, of which SLAM's key frames have SLAM's poses, moved as a whole to lie
/// as near as possible to the reference poses.
Result<RecordedLog> with_slam_poses(const RecordedLog& log, std::size_t end,
                                    const EvaluationOptions& options) {
  RecordedLog posed{log.header,
                    {log.scans.begin(), log.scans.begin() + static_cast<std::ptrdiff_t>(end)}};
  Progress progress("slam");
  const Result<SlamRun> run = run_slam(posed.scans, options.use_odometry, options.mapper,
                                       [&](double share) { progress.update(share); });
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

int run_evaluate(EvaluateArguments& arguments) {
  EvaluationOptions& options = arguments.options;
  const auto method = method_from_string(arguments.method);
  if (!method) throw CLI::ValidationError("--method", "unknown method " + arguments.method);
  options.localizer.method = *method;
  const auto extractor = corner_extractor_from_string(arguments.extractor);
  if (!extractor)
    throw CLI::ValidationError("--extractor", "unknown extractor " + arguments.extractor);
  options.mapper.extractor = options.localizer.extractor = *extractor;
  options.use_odometry = !arguments.no_odometry;
  options.sample = !arguments.samples.empty();

  Result<RecordedLog> log = read_log(arguments.log);
  if (!log) return fail(log.error());
  std::optional<RecordedLog> own_map_log;
  const std::string& map_path =
      arguments.other_map_log.empty() ? arguments.map_log : arguments.other_map_log;
  if (!map_path.empty()) {
    Result<RecordedLog> other = read_log(map_path);
    if (!other) return fail(other.error());
    own_map_log = std::move(*other);
  }
  std::size_t end = own_map_log ? own_map_log->scans.size() : split_index(*log, options.split);
  if (arguments.slam) {
    Result<RecordedLog> found = with_slam_poses(own_map_log ? *own_map_log : *log, end, options);
    if (!found) return fail(found.error());
    own_map_log = std::move(*found);
  }
  const RecordedLog& map_source = own_map_log ? *own_map_log : *log;
  Evaluation evaluation = map_from(map_source, end, options.mapper);
  // In a building of its own no place is near a mapped one and every fix is a false one.
  const bool elsewhere = !arguments.other_map_log.empty();
  const std::size_t right_map = elsewhere ? kNoMap : 0;

  Progress progress("starts");
  evaluation.records =
      evaluate(*log, map_path.empty() ? end : 0, {evaluation.map}, right_map,
               elsewhere ? std::vector<Point2>{} : evaluation.mapping_positions, options,
               [&](std::size_t done, std::size_t all) {
                 progress.update(static_cast<double>(done) / static_cast<double>(all));
               });
  std::printf("%s\n", summary_json(log->header.name, evaluation, options).c_str());
  if (!arguments.csv.empty()) {
    if (const auto written = write_records(arguments.csv, evaluation.records); !written)
      return fail(written.error());
  }
  if (options.sample) {
    const auto written = append_samples(arguments.samples, sample_name(arguments, log->header.name),
                                        evaluation.records);
    if (!written) return fail(written.error());
  }
  return kDone;
}

}  // namespace

void add_evaluate_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<EvaluateArguments>();
  EvaluationOptions& options = arguments->options;
  options.threads = std::max(1U, std::thread::hardware_concurrency());
  CLI::App* command = app.add_subcommand(
      "evaluate",
      "Score the localizer on a log with reference poses: one part maps, the rest asks");
  command->option_defaults()->always_capture_default();
  command->add_option("LOG", arguments->log, "Log whose scans ask")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--split", options.split, "Share of LOG that makes the map")
      ->check(CLI::Range(0.0, 1.0));
  CLI::Option* map_log = command
                             ->add_option("--map-log", arguments->map_log,
                                          "Log that makes the map, in LOG's frame; all of LOG asks")
                             ->check(CLI::ExistingFile);
  command
      ->add_option("--elsewhere", arguments->other_map_log,
                   "Log of another building that makes the map: every fix is a false one")
      ->check(CLI::ExistingFile)
      ->excludes(map_log);
  command->add_option("--starts", options.starts, "Robots switched on along LOG");
  command->add_option("--near", options.near_m,
                      "Metres from a mapping pose: a start in the mapped part");
  command->add_option("--way", options.way_m, "Metres of driving allowed until the fix");
  command->add_option("--time", options.time_s, "Seconds of log time allowed until the fix");
  command->add_option("--track", options.track_m, "Metres to follow after the fix");
  command->add_option("--batch", options.batch, "Scans a question");
  command->add_option("--method", arguments->method,
                      "Where hypotheses come from: indexed, rma or nma");
  command->add_option("--extractor", arguments->extractor, "How corners are found: two_arm or vfp");
  command->add_option("--threads", options.threads, "Robots at once");
  command->add_flag("--no-odom", arguments->no_odometry, "Ask without odometry");
  command->add_flag("--slam", arguments->slam,
                    "Make the map without its log's poses; these only say where it lies");
  command->add_flag("--mirror", options.mirror, "Turn the scans over: every fix is a false one");
  command->add_option("--csv", arguments->csv, "Write a row a start here");
  command->add_option(
      "--samples", arguments->samples,
      "Never accept; append what each search of the map knew here, for calibration");
  command->callback([arguments, &exit_code] { exit_code = run_evaluate(*arguments); });
}

}  // namespace cornerfix::cli

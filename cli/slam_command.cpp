#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "cli/command.hpp"
#include "cli/progress.hpp"
#include "cli/whole_log.hpp"
#include "evaluation/metrics/revisit_score.hpp"
#include "evaluation/metrics/slam_run.hpp"
#include "evaluation/metrics/trajectory_score.hpp"

namespace cornerfix::cli {

namespace {

struct SlamArguments {
  std::string log;
  evaluation::LogSelection selection;
  bool no_odometry = false;
};

double rounded(double value) { return std::round(1e4 * value) / 1e4; }

nlohmann::ordered_json spread(std::vector<double> values, double unit) {
  std::ranges::sort(values);
  const auto count = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  const auto at = [&](double share) {
    return rounded(values[static_cast<std::size_t>(share * (count - 1.0))] / unit);
  };
  return {{"mean", rounded(mean / unit)}, {"p50", at(0.5)}, {"p95", at(0.95)}, {"max", at(1.0)}};
}

nlohmann::ordered_json spreads(const evaluation::RelativePoseError& error) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  return {{"error_m", spread(error.errors_m, 1.0)},
          {"error_deg", spread(error.errors_rad, kDegree)}};
}

nlohmann::ordered_json error_json(const evaluation::RelativePoseError& error) {
  nlohmann::ordered_json json = {{"way_m", error.way_m}, {"relations", error.errors_m.size()}};
  json.update(spreads(error));
  return json;
}

/// The errors of the trajectory, and of the log's reference, over pairs of scans of one place.
nlohmann::ordered_json revisits_json(std::span<const evaluation::LogScan> scans,
                                     const evaluation::SlamRun& run) {
  std::vector<std::size_t> indices = evaluation::reference_scans(scans);
  std::vector<std::vector<Pose2>> trajectories = {run.T_map_laser};
  if (indices.empty()) {
    indices = run.key_scans;
  } else {
    trajectories.emplace_back();
    for (const evaluation::LogScan& scan : scans)
      trajectories.back().push_back(scan.T_map_laser.value_or(Pose2{}));
  }
  const evaluation::RevisitScore score = evaluation::score_revisits(scans, indices, trajectories);
  nlohmann::ordered_json json = {{"pairs", score.pairs}, {"undecided", score.undecided}};
  if (score.pairs == 0) return json;
  json["found"] = spreads(score.errors.front());
  if (score.errors.size() > 1) json["reference"] = spreads(score.errors.back());
  return json;
}

int run_slam_command(const SlamArguments& arguments) {
  const Result<evaluation::RecordedLog> log = read_whole_log(arguments.log, arguments.selection);
  if (!log) return fail(log.error());
  Progress progress("slam");
  const std::clock_t begin = std::clock();
  const Result<evaluation::SlamRun> run = evaluation::run_slam(
      log->scans, !arguments.no_odometry, {}, [&](double share) { progress.update(share); });
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  if (!run) return fail(run.error());
  nlohmann::ordered_json summary = {{"log", log->header.name},
                                    {"scans", log->scans.size()},
                                    {"keyframes", run->key_scans.size()},
                                    {"submaps", run->submaps},
                                    {"loop_closures", run->loop_closures},
                                    {"cpu_seconds", rounded(seconds)}};
  for (const double way_m : {2.0, 20.0}) {
    const evaluation::RelativePoseError error =
        evaluation::relative_pose_error(log->scans, run->T_map_laser, way_m);
    if (!error.errors_m.empty()) summary["relative_pose_error"].push_back(error_json(error));
  }
  summary["revisits"] = revisits_json(log->scans, *run);
  std::printf("%s\n", summary.dump(1).c_str());
  return kDone;
}

}  // namespace

void add_slam_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SlamArguments>();
  CLI::App* command = app.add_subcommand(
      "slam", "Find the trajectory of a log without its poses, and score it against them");
  command->footer(
      "Prints the error of relative poses (Kuemmerle et al. 2009) between reference poses 2 m and "
      "20 m of way apart; and of both trajectories, or of the one found, between scans of one "
      "place, "
      "20 m of way and more apart, that are laid on each other.");
  add_log(*command, arguments->log);
  add_selection(*command, arguments->selection);
  command->add_flag("--no-odom", arguments->no_odometry, "Use the scans alone");
  command->callback([arguments, &exit_code] { exit_code = run_slam_command(*arguments); });
}

}  // namespace cornerfix::cli

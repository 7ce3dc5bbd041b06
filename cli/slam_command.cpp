#include <cstdio>
#include <ctime>
#include <memory>
#include <string>

#include "cli/command.hpp"
#include "cli/progress.hpp"
#include "evaluation/metrics/slam_report.hpp"

namespace cornerfix::cli {

namespace {

struct SlamArguments {
  std::string log;
  evaluation::LogSelection selection;
  bool no_odometry = false;
};

int run_slam_command(const SlamArguments& arguments) {
  const Result<evaluation::RecordedLog> log = read_whole_log(arguments.log, arguments.selection);
  if (!log) return fail(log.error());
  Progress progress("slam");
  const std::clock_t begin = std::clock();
  const Result<evaluation::SlamRun> run = evaluation::run_slam(
      log->scans, !arguments.no_odometry, {}, [&](double share) { progress.update(share); });
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  if (!run) return fail(run.error());
  std::printf("%s\n", evaluation::slam_report_json(*log, *run, seconds).dump(1).c_str());
  return kDone;
}

}  // namespace

void add_slam_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SlamArguments>();
  CLI::App* command = app.add_subcommand(
      "slam", "Find the trajectory of a log without its poses, and score it against them");
  command->footer(
      "Prints the errors of relative poses (Kuemmerle et al. 2009) over 2 m and 20 m of path, and\n"
      "those between registered scans of one place that are 20 m of path or more apart. The "
      "latter\n"
      "are of the trajectory that was found and of the reference poses.");
  add_log(*command, arguments->log);
  add_selection(*command, arguments->selection);
  command->add_flag("--no-odom", arguments->no_odometry, "Use the scans alone");
  command->callback([arguments, &exit_code] { exit_code = run_slam_command(*arguments); });
}

}  // namespace cornerfix::cli

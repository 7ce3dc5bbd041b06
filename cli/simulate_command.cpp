#include <cornerfix/map_image.hpp>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>

#include "cli/command.hpp"
#include "cli/progress.hpp"
#include "evaluation/datasets/log_writer.hpp"
#include "evaluation/datasets/robot_scans.hpp"
#include "evaluation/simulation/run_simulator.hpp"

namespace cornerfix::cli {

namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

struct SimulateArguments {
  std::string map;
  std::string out;
  std::string inside;
  std::string name;
  double field_of_view_deg = 270.0;
  std::string odometry_fault;
  evaluation::RunOptions run;
};

std::string plain_stem(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  return name.substr(0, name.find('.'));
}

Result<evaluation::RecordedLog> simulate(const SimulateArguments& arguments) {
  const Result<OccupancyGrid> map = read_map_files(arguments.map);
  if (!map) return map.error();
  std::optional<OccupancyGrid> inside;
  if (!arguments.inside.empty()) {
    Result<OccupancyGrid> other = read_map_files(arguments.inside);
    if (!other) return other.error();
    inside = std::move(*other);
  }
  Progress progress("driving");
  Result<evaluation::RecordedLog> log =
      evaluation::simulate_run(*map, arguments.run, inside ? &*inside : nullptr,
                               [&](double share) { progress.update(share); });
  if (!log) return log;
  log->header.name = arguments.name.empty() ? plain_stem(arguments.out) : arguments.name;
  const std::filesystem::path driven = arguments.inside.empty() ? arguments.map : arguments.inside;
  log->header.source = evaluation::describe_run(driven.filename().string(), arguments.run);
  return log;
}

int run_simulate(SimulateArguments& arguments) {
  arguments.run.odometry_fault = evaluation::odometry_fault_from_string(arguments.odometry_fault);
  arguments.run.field_of_view_rad = arguments.field_of_view_deg * kRadiansPerDegree;
  if (const auto error = evaluation::validate(arguments.run)) {
    throw CLI::ValidationError(error->field, error->message);
  }
  const Result<evaluation::RecordedLog> log = simulate(arguments);
  if (!log) return fail(log.error());
  Progress progress("writing");
  const Result<void> written =
      evaluation::write_log(arguments.out, *log, [&](double share) { progress.update(share); });
  if (!written) return fail(written.error());
  evaluation::DistanceTraveled distance;
  for (const evaluation::LogScan& scan : log->scans) distance.add(scan);
  std::printf("%s: %zu scans along %.1f m\n", arguments.out.c_str(), log->scans.size(),
              distance.m());
  return kDone;
}

}  // namespace

void add_simulate_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SimulateArguments>();
  evaluation::RunOptions& run = arguments->run;
  CLI::App* command = app.add_subcommand(
      "simulate", "Drive a simulated lidar through an occupancy map and record what it sees");
  command->option_defaults()->always_capture_default();
  command->add_option("MAP", arguments->map, "ROS map_server yaml")
      ->required()
      ->check(CLI::ExistingFile)
      ->capture_default_str();
  command->add_option("OUT", arguments->out, "Log to write, .jsonl or .jsonl.gz")->required();
  command->add_option("--length", run.length_m, "Metres to drive");
  command->add_option("--step", run.step_m, "Metres between scans");
  command->add_option("--start", run.start_s,
                      "Stamp of the first scan in seconds: a later run in the same building "
                      "begins five minutes after the one before, or more");
  command->add_option("--fov", arguments->field_of_view_deg, "Field of view in degrees");
  command->add_option("--beams", run.beams, "Beams of a scan");
  command->add_option("--range-max", run.range_max_m, "Longest range in metres");
  command->add_option("--noise", run.range_noise_m, "Standard deviation of a range in metres");
  command->add_option("--drift", run.drift,
                      "Odometry error as a share of the path length, 0 for none");
  command
      ->add_option("--odom-fault", arguments->odometry_fault,
                   "Corrupt the odometry that is recorded")
      ->check(CLI::IsMember(evaluation::odometry_fault_names()));
  command->add_option("--people", run.people, "People who walk about the robot");
  command->add_option("--boxes", run.boxes, "Boxes along the path that are not in the map");
  command
      ->add_option("--inside", arguments->inside,
                   "Yaml of the building as it is now, in the frame of MAP: rays are cast there, "
                   "along a path that is free in both")
      ->check(CLI::ExistingFile);
  command->add_option("--seed", run.seed, "Same seed, same log");
  command->add_option("--name", arguments->name, "Name in the log's header (default: OUT's)");
  command->callback([arguments, &exit_code] { exit_code = run_simulate(*arguments); });
}

}  // namespace cornerfix::cli

#include <cornerfix/map_image.hpp>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>

#include "cli/command.hpp"
#include "cli/progress.hpp"
#include "evaluation/datasets/log_writer.hpp"
#include "evaluation/simulation/odometry_fault.hpp"
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
  evaluation::DriveOptions drive;
};

std::string plain_stem(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  return name.substr(0, name.find('.'));
}

/// How the log came about, for those who find it later.
std::string source_of(const SimulateArguments& arguments) {
  const std::filesystem::path map = arguments.inside.empty() ? arguments.map : arguments.inside;
  char text[256];
  std::snprintf(text, sizeof text, "seed %llu, noise %g m, drift %g, people %d, boxes %d",
                static_cast<unsigned long long>(arguments.drive.seed),
                arguments.drive.range_noise_m, arguments.drive.drift, arguments.drive.people,
                arguments.drive.boxes);
  const std::string fault =
      arguments.odometry_fault.empty() ? "" : ", odometry fault " + arguments.odometry_fault;
  return "simulated drive in " + map.filename().string() + ", " + text + fault;
}

Result<void> write_log(const std::filesystem::path& path, const evaluation::RecordedLog& log) {
  Result<evaluation::LogWriter> writer = evaluation::LogWriter::create(path, log.header);
  if (!writer) return writer.error();
  Progress progress("writing");
  for (std::size_t i = 0; i < log.scans.size(); ++i) {
    Result<void> written = writer->write(log.scans[i]);
    if (!written) return written;
    progress.update(static_cast<double>(i + 1) / static_cast<double>(log.scans.size()));
  }
  return writer->close();
}

double length_of(const evaluation::RecordedLog& log) {
  double length = 0.0;
  for (std::size_t i = 1; i < log.scans.size(); ++i) {
    length += distance(*log.scans[i - 1].T_map_laser, *log.scans[i].T_map_laser);
  }
  return length;
}

void corrupt_odometry(evaluation::RecordedLog& log, const SimulateArguments& arguments) {
  const auto kind = evaluation::odometry_fault_from_string(arguments.odometry_fault);
  if (!kind) return;
  evaluation::OdometryFault fault(*kind, arguments.drive.seed);
  for (evaluation::LogScan& scan : log.scans)
    scan.T_odom_laser = fault.corrupt(scan.scan.stamp, *scan.T_odom_laser);
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
      evaluation::simulate_drive(*map, arguments.drive, inside ? &*inside : nullptr,
                                 [&](double share) { progress.update(share); });
  if (!log) return log;
  corrupt_odometry(*log, arguments);
  log->header.name = arguments.name.empty() ? plain_stem(arguments.out) : arguments.name;
  log->header.source = source_of(arguments);
  return log;
}

int run_simulate(SimulateArguments& arguments) {
  arguments.drive.field_of_view_rad = arguments.field_of_view_deg * kRadiansPerDegree;
  if (const auto error = evaluation::validate(arguments.drive)) {
    throw CLI::ValidationError(error->field, error->message);
  }
  const Result<evaluation::RecordedLog> log = simulate(arguments);
  if (!log) return fail(log.error());
  const Result<void> written = write_log(arguments.out, *log);
  if (!written) return fail(written.error());
  std::printf("%s: %zu scans along %.1f m\n", arguments.out.c_str(), log->scans.size(),
              length_of(*log));
  return kDone;
}

}  // namespace

void add_simulate_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SimulateArguments>();
  evaluation::DriveOptions& drive = arguments->drive;
  CLI::App* command = app.add_subcommand(
      "simulate", "Drive a simulated lidar through a floor map and record what it sees");
  command->option_defaults()->always_capture_default();
  command->add_option("MAP", arguments->map, "ROS map_server yaml")
      ->required()
      ->check(CLI::ExistingFile)
      ->capture_default_str();
  command->add_option("OUT", arguments->out, "Log to write, .jsonl or .jsonl.gz")->required();
  command->add_option("--length", drive.length_m, "Metres to drive");
  command->add_option("--step", drive.step_m, "Metres between scans");
  command->add_option("--start", drive.start_s,
                      "Stamp of the first scan in seconds: a later drive in the same building "
                      "begins five minutes after the one before, or more");
  command->add_option("--fov", arguments->field_of_view_deg, "Field of view in degrees");
  command->add_option("--beams", drive.beams, "Beams of a scan");
  command->add_option("--range-max", drive.range_max_m, "Longest range in metres");
  command->add_option("--noise", drive.range_noise_m, "Standard deviation of a range in metres");
  command->add_option("--drift", drive.drift, "Odometry error as a share of the way, 0 for none");
  command
      ->add_option("--odom-fault", arguments->odometry_fault,
                   "Corrupt the odometry that is recorded")
      ->check(CLI::IsMember(evaluation::odometry_fault_names()));
  command->add_option("--people", drive.people, "People who walk about the robot");
  command->add_option("--boxes", drive.boxes, "Boxes along the way that the map does not know");
  command
      ->add_option("--inside", arguments->inside,
                   "Yaml of the building as it is now, in the frame of MAP: rays are cast there, "
                   "along a way that is free in both")
      ->check(CLI::ExistingFile);
  command->add_option("--seed", drive.seed, "Same seed, same log");
  command->add_option("--name", arguments->name, "Name in the log's header (default: OUT's)");
  command->callback([arguments, &exit_code] { exit_code = run_simulate(*arguments); });
}

}  // namespace cornerfix::cli

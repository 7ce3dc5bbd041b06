#include "bench/experiments/buildings.hpp"

#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include <cornerfix/map_image.hpp>

#include "bench/experiments/experiment.hpp"
#include "evaluation/simulation/run_simulator.hpp"

namespace cornerfix::bench {
namespace {

/// The scans that Cartographer puts into its grid, by its motion filter: one after 0.2 m, 1 deg or
/// 5 s.
std::vector<PosedScan> filtered_by_motion(std::span<const evaluation::LogScan> scans) {
  constexpr double kDistance = 0.2;
  constexpr double kAngle = std::numbers::pi / 180.0;
  constexpr double kTime = 5.0;
  std::vector<PosedScan> kept;
  for (const evaluation::LogScan& scan : scans) {
    if (!scan.T_map_laser) continue;
    const PosedScan posed{scan.scan, {}, *scan.T_map_laser};
    if (kept.empty() || distance(kept.back().T_map_base_link, posed.T_map_base_link) > kDistance ||
        angle_between(kept.back().T_map_base_link, posed.T_map_base_link) > kAngle ||
        posed.scan.stamp - kept.back().scan.stamp > kTime)
      kept.push_back(posed);
  }
  return kept;
}

/// The first `end` scans of `mapping` map.
Building building_of(const std::string& name, const evaluation::RecordedLog& mapping,
                     std::size_t end, evaluation::RecordedLog asking, std::size_t begin) {
  evaluation::Evaluation mapped = evaluation::map_from(mapping, end, {});
  return {
      map_building(name, mapped.keyframes, filtered_by_motion(std::span(mapping.scans).first(end))),
      std::move(mapped.mapping_positions), std::move(asking), begin};
}

/// Every other scan of a log, from the first or the second on.
evaluation::RecordedLog every_other(const evaluation::RecordedLog& log, std::size_t first) {
  evaluation::RecordedLog half = log;
  half.scans.clear();
  for (std::size_t i = first; i < log.scans.size(); i += 2) half.scans.push_back(log.scans[i]);
  return half;
}

Building recorded(const BuildingSource& source) {
  evaluation::RecordedLog log = value_or_exit(evaluation::read_log(source.log));
  if (source.even_odd) {
    const evaluation::RecordedLog mapping = every_other(log, 0);
    return building_of(source.name, mapping, mapping.scans.size(), every_other(log, 1), 0);
  }
  const std::size_t end = evaluation::split_index(log, source.split);
  return building_of(source.name, log, end, log, end);
}

Building simulated(const BuildingSource& source) {
  const OccupancyGrid floor = value_or_exit(read_map_files(source.floor_map));
  std::optional<OccupancyGrid> inside;
  if (!source.inside.empty()) inside = value_or_exit(read_map_files(source.inside));
  // Along a path that is free in both, or the runs might be in rooms that are not connected.
  const evaluation::RecordedLog mapping = value_or_exit(evaluation::simulate_run(
      inside ? *inside : floor,
      {.drift = 0.0, .length_m = source.mapping_m, .step_m = 0.3, .seed = 1},
      inside ? &floor : nullptr));
  evaluation::RecordedLog asking = value_or_exit(evaluation::simulate_run(
      floor, {.people = source.people, .length_m = source.asking_m, .seed = 2},
      inside ? &*inside : nullptr));
  return building_of(source.name, mapping, mapping.scans.size(), std::move(asking), 0);
}

}  // namespace

void add_building_options(CLI::App& command, BuildingSource& source) {
  command.add_option("--name", source.name, "Of the building, in tables")->required();
  CLI::Option* log = command.add_option("--log", source.log, "Recorded run with reference poses")
                         ->check(CLI::ExistingFile);
  CLI::Option* split = command.add_option("--split", source.split, "Share of the log that maps")
                           ->check(CLI::Range(0.0, 1.0));
  command
      .add_flag("--even-odd", source.even_odd, "Every other scan of the log maps, the others ask")
      ->needs(log)
      ->excludes(split);
  CLI::Option* floor =
      command
          .add_option("--floor-map", source.floor_map, "ROS map_server yaml to simulate runs in")
          ->check(CLI::ExistingFile)
          ->excludes(log);
  command
      .add_option("--inside", source.inside,
                  "Yaml of the building as it is when asked, in the frame of the floor map")
      ->check(CLI::ExistingFile)
      ->needs(floor);
  command.add_option("--mapping-length", source.mapping_m, "Metres of the simulated mapping drive");
  command.add_option("--asking-length", source.asking_m, "Metres of the simulated run that asks");
  command.add_option("--people", source.people, "People about the robot on that drive");
}

Building open_building(const BuildingSource& source) {
  return source.log.empty() ? simulated(source) : recorded(source);
}

}  // namespace cornerfix::bench

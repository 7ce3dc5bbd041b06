#include "bench/experiments/buildings.hpp"

#include <optional>
#include <utility>

#include <cornerfix/map_image.hpp>

#include "bench/experiments/experiment.hpp"
#include "cli/drive_simulator.hpp"

namespace cornerfix::bench {
namespace {

Building building_of(const std::string& name, cli::Evaluation mapped, cli::RecordedLog log,
                     std::size_t begin) {
  return {map_building(name, std::move(mapped.key_frames)), std::move(mapped.mapping_positions),
          std::move(log), begin};
}

Building recorded(const BuildingSource& source) {
  cli::RecordedLog log = value_or_exit(cli::read_log(source.log));
  const std::size_t end = cli::split_index(log, source.split);
  cli::Evaluation mapped = cli::map_from(log, end, {});
  return building_of(source.name, std::move(mapped), std::move(log), end);
}

Building simulated(const BuildingSource& source) {
  const OccupancyGrid floor = value_or_exit(read_map_files(source.floor_map));
  std::optional<OccupancyGrid> inside;
  if (!source.inside.empty()) inside = value_or_exit(read_map_files(source.inside));
  const cli::RecordedLog mapping = value_or_exit(cli::simulate_drive(
      floor, {.drift = 0.0, .length_m = source.mapping_m, .step_m = 0.3, .seed = 1}));
  cli::RecordedLog asking = value_or_exit(
      cli::simulate_drive(floor, {.people = source.people, .length_m = source.asking_m, .seed = 2},
                          inside ? &*inside : nullptr));
  return building_of(source.name, cli::map_from(mapping, mapping.scans.size(), {}),
                     std::move(asking), 0);
}

}  // namespace

void add_building_options(CLI::App& command, BuildingSource& source) {
  command.add_option("--name", source.name, "Of the building, in tables")->required();
  CLI::Option* log = command.add_option("--log", source.log, "Recorded drive with reference poses")
                         ->check(CLI::ExistingFile);
  command.add_option("--split", source.split, "Share of the log that maps")
      ->check(CLI::Range(0.0, 1.0));
  CLI::Option* floor =
      command
          .add_option("--floor-map", source.floor_map, "ROS map_server yaml to simulate drives in")
          ->check(CLI::ExistingFile)
          ->excludes(log);
  command
      .add_option("--inside", source.inside,
                  "Yaml of the building as it is when asked, in the frame of the floor map")
      ->check(CLI::ExistingFile)
      ->needs(floor);
  command.add_option("--mapping-length", source.mapping_m, "Metres of the simulated mapping drive");
  command.add_option("--asking-length", source.asking_m, "Metres of the simulated drive that asks");
  command.add_option("--people", source.people, "People about the robot on that drive");
}

Building open_building(const BuildingSource& source) {
  return source.log.empty() ? simulated(source) : recorded(source);
}

}  // namespace cornerfix::bench

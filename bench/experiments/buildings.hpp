/// \file  The buildings that robots are started in: recorded, or a simulated run in an occupancy
/// map.
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>
#include <vector>

#include "bench/experiments/contestants.hpp"
#include "evaluation/datasets/log_reader.hpp"
#include "evaluation/metrics/localization_score.hpp"

namespace cornerfix::bench {

/// Where a building comes from. One of `log` and `floor_map` is named.
struct BuildingSource {
  std::string name;
  std::string log;            ///< A recorded run; its first part maps, the rest asks.
  double split = 0.5;         ///< Share of the log that maps.
  bool even_odd = false;      ///< Every other scan maps instead: all of the building is mapped.
  std::string floor_map;      ///< ROS map_server yaml: a simulated run maps, another asks.
  std::string inside;         ///< The building as it is when asked, in the frame of `floor_map`.
  double mapping_m = 1200.0;  ///< Of the simulated run that maps.
  double asking_m = 400.0;    ///< Of the one that asks.
  int people = 4;             ///< About the robot while it asks.
};

void add_building_options(CLI::App& command, BuildingSource& source);

/// A building with the run that asks.
struct Building {
  MappedBuilding mapped;
  std::vector<Point2> mapping_positions;  ///< Of the laser.
  evaluation::RecordedLog log;
  std::size_t begin = 0;  ///< Index of the first scan of `log` that asks.
};

/// Ends the program when the files cannot be read.
[[nodiscard]] Building open_building(const BuildingSource& source);

}  // namespace cornerfix::bench

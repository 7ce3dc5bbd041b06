/// \file  A simulated run through an occupancy map: what a robot would have recorded there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <string>

#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

#include "evaluation/datasets/log_reader.hpp"
#include "evaluation/simulation/odometry_fault.hpp"

namespace cornerfix::evaluation {

/// The lidar, the run, and what goes wrong. Defaults: a common safety scanner.
struct RunOptions {
  double field_of_view_rad = 1.5 * std::numbers::pi;  ///< About straight ahead; in (0, 2 pi].
  std::size_t beams = 1081;                           ///< >= 2.
  double range_max_m = 30.0;                          ///< > 0.05, which is range_min.
  double range_noise_m = 0.02;                        ///< Standard deviation; >= 0.
  double drift = 0.02;      ///< Odometry error as a share of the path length; 0 is perfect.
  int people = 0;           ///< Who walk about the robot; >= 0.
  int boxes = 0;            ///< Put beside the path, unknown to the map; >= 0.
  double length_m = 300.0;  ///< > 0.
  double step_m = 0.08;     ///< Between scans; > 0.
  double start_s = 0.0;     ///< Stamp of the first scan [s]; within 1e10 of 0.
  /// Corrupts the odometry that is recorded, with `seed`; nothing for none.
  std::optional<OdometryFaultKind> odometry_fault = {};
  std::uint64_t seed = 1;  ///< Same seed, maps and options give the same log.
};

/// The first broken limit, or nothing when `options` can be used.
[[nodiscard]] std::optional<Error> validate(const RunOptions& options);

/// Drives through `map`, with exact reference poses. People, boxes, noise and drift each draw from
/// their own random numbers, so changing one leaves the path and the others as they were.
///
/// \param inside       Where the robot really is, in the same frame as `map`, when the building
///                     has changed: rays are cast there, on a path that is free in both.
/// \param on_progress  Called with the share that is done, in [0, 1]; may be empty.
[[nodiscard]] Result<RecordedLog> simulate_run(const OccupancyGrid& map, const RunOptions& options,
                                               const OccupancyGrid* inside = nullptr,
                                               const std::function<void(double)>& on_progress = {});

/// How a log came about, for those who find it later: the map, the seed and what goes wrong.
[[nodiscard]] std::string describe_run(const std::string& map_name, const RunOptions& options);

}  // namespace cornerfix::evaluation

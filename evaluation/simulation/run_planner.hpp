/// \file  A smooth path for a robot through the free space of occupancy maps.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix::evaluation {

struct RunPlanOptions {
  double length_m = 300.0;     ///< Of the whole path; > 0.
  double step_m = 0.08;        ///< Between poses; > 0.
  double max_turn_rad = 0.15;  ///< Between poses; more is turned on the spot; > 0.
  double clearance_m = 0.28;   ///< Kept to all that is not free, so that doors can be passed; > 0.
  std::uint64_t seed = 1;      ///< Same seed and maps give the same path.
};

/// Poses in `map` along a path between random goals, the unvisited first, so that a long run sees
/// all of the largest space that can be reached. Every pose is free in all of `maps`, which share
/// one frame; there is at least one.
///
/// \return kInvalidArgument where no space is wide enough to drive in.
[[nodiscard]] Result<std::vector<Pose2>> plan_run(std::span<const OccupancyGrid* const> maps,
                                                  const RunPlanOptions& options);

}  // namespace cornerfix::evaluation

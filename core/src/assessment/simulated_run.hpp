/// \file  The way of a robot that drives ahead while there is room and turns aside where there is
/// none.
#pragma once

#include <vector>

#include <cornerfix/pose2.hpp>

#include "core/src/scan/simulated_scan.hpp"

namespace cornerfix {

/// From `T_map_base_link`, which comes first, until `way_m` is driven: a pose every 0.5 m, and
/// every 30 degrees of a turn on the spot. Shorter only where the robot is shut in.
[[nodiscard]] std::vector<Pose2> simulated_run(const SimulatedLidar& lidar,
                                               const Pose2& T_map_base_link, double way_m);

}  // namespace cornerfix

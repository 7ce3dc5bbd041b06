/// \file  Keyframes at poses to an occupancy grid, by counting where beams end and where they
/// pass.
#pragma once

#include <span>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/mapper.hpp>
#include <cornerfix/occupancy_grid.hpp>

namespace cornerfix {

/// Occupied where beams ended, free where they passed, unknown elsewhere; T_map_grid has yaw 0 and
/// lies on whole cells. Where keyframes of a later run (mapping_drive.hpp) looked, earlier
/// drives weigh little: what is gone is free after twenty beams. O(beams * range / resolution +
/// drives * cells). Empty input gives an empty grid.
[[nodiscard]] OccupancyGrid build_occupancy_grid(std::span<const PosedScan> key_frames,
                                                 const OccupancyMappingParams& params);

}  // namespace cornerfix

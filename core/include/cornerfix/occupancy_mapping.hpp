/// \file  Key frames at poses to an occupancy grid, by counting where beams end and where they
/// pass.
#pragma once

#include <optional>
#include <span>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

struct OccupancyMappingParams {
  double resolution_m = 0.05;  ///< [m/cell]; > 0.
  double max_range_m = 30.0;   ///< Longer returns are left out: their ends lie too far apart; > 0.
  double min_peak_share = 0.35;  ///< A wall has this share of the most hits around it, else walls
                                 ///< grow thick; in [0, 1].
  double min_hit_share = 0.20;   ///< And this share of the beams that came to it ended there, else
                                 ///< people stay; in [0, 1].
};

[[nodiscard]] std::optional<Error> validate(const OccupancyMappingParams& params);

/// Axis-aligned box in `map` [m].
struct Bounds {
  Point2 min = Point2::Zero();
  Point2 max = Point2::Zero();

  void extend(const Bounds& other) {
    min = min.cwiseMin(other.min);
    max = max.cwiseMax(other.max);
  }
};

/// Where the robot stood and what it saw within max_range_m.
[[nodiscard]] Bounds bounds_of(const PosedScan& scan, const OccupancyMappingParams& params);

/// Occupied where beams ended, free where they passed, unknown elsewhere; T_map_grid has yaw 0 and
/// lies on whole cells. Where key frames of a later drive (mapping_drive.hpp) looked, earlier
/// drives weigh little: what is gone is free after twenty beams. O(beams * range / resolution +
/// drives * cells). Empty input gives an empty grid.
[[nodiscard]] OccupancyGrid build_occupancy_grid(std::span<const PosedScan> key_frames,
                                                 const OccupancyMappingParams& params);

}  // namespace cornerfix

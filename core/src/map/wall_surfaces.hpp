/// \file  Where the walls of an occupancy map show their surface to a lidar, as a grid to localize
/// in.
///
/// An occupancy map is drawn, or was made by another program: of any resolution, its walls as thick
/// as they were drawn, their rims often grey. A lidar sees only where a wall meets open space.
#pragma once

#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

/// An occupied cell farther than this from free space is no surface [m].
inline constexpr double kMaxRimWidth = 0.16;

/// An occupancy map whose grey rims are free: unknown cells on a way, at most kMaxRimWidth long,
/// from free space to a wall. O(cells).
[[nodiscard]] OccupancyGrid without_grey_rims(OccupancyGrid floor_map);

struct WallSurfaces {
  /// Of walls only what touches free space is occupied; what is behind is unknown, as to a lidar.
  /// Where walls are one fine cell thick, as mapping programs make them, their surface is in the
  /// middle of these cells. Else it is at their border, and cells are centred on the borders.
  OccupancyGrid grid;
  double median_thickness_m = 0.0;  ///< Of the walls behind their surface, up to 1 m; 0 without.
};

/// The surfaces of `floor_map`, cut to what is known of it. The cells of the result are whole
/// multiples or whole parts of its cells, as near to `resolution_m` as that can be; the frame is
/// turned as the map's is. kTooLarge when they would be more than `max_cells`. O(cells).
[[nodiscard]] Result<WallSurfaces> find_wall_surfaces(const OccupancyGrid& floor_map,
                                                      double resolution_m, double max_cells);

}  // namespace cornerfix

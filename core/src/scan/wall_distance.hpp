/// \file  Distances to walls all over a grid.
#pragma once

#include <vector>

#include <cornerfix/occupancy_grid.hpp>

namespace cornerfix {

/// Of each cell's centre to that of the nearest occupied cell, in cells, row by row; infinite where
/// there is none. In a grid wider than some thousand cells, distances above 256 may be given as
/// 256. O(cells).
[[nodiscard]] std::vector<float> distances_to_walls(const OccupancyGrid& grid);

}  // namespace cornerfix

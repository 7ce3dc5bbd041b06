/// \file  From a floor map alone, without any scan, to a map that robots localize in.
///
/// Features come from virtual scans in the free space, so they are what a lidar would see there;
/// the grid holds the surfaces of the walls.
#pragma once

#include <string>
#include <vector>

#include <cornerfix/mapper.hpp>
#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

struct GridMap {
  MapContent content;                 ///< `grid` is turned as the floor map is.
  std::vector<std::string> warnings;  ///< What the map's owner should know; one sentence each.
};

/// Of `params` the extractor, the features, the descriptors, the grid's resolution and the least
/// count of a feature are used; a count is of virtual scans, one a square metre of free space.
///
/// \return kInvalidArgument for a map without free cells or without walls, kTooLarge for one of
/// more than Mapper::kMaxCells cells at the wanted resolution.
///
/// O(cells + free space), on all cores. Less than 1 s of processor time for 1,000 m2 of free space.
[[nodiscard]] Result<GridMap> map_from_grid(const OccupancyGrid& floor_map,
                                            const MapperParams& params);

}  // namespace cornerfix

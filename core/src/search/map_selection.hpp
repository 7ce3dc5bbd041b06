/// \file  Which maps of a source are loaded for a search.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <cornerfix/localizer_params.hpp>
#include <cornerfix/map_source.hpp>

#include "core/src/local_map/view.hpp"

namespace cornerfix {

struct MapSelection {
  std::vector<MapKey> keys;
  std::vector<LocalizationMapPtr> maps;  ///< In the order of `keys`.
  std::size_t unsearched = 0;            ///< Maps that may hold the robot and are not among them.
  bool is_ranked = false;  ///< False: too few corners were seen, so all others are unsearched.
};

/// What a selection depends on besides the view.
struct SelectionRequest {
  MapSelection kept;                         ///< Maps with candidates come first.
  const std::optional<StartRegion>& region;  ///< While it restricts the search.
  double distance_m = 0.0;                   ///< Driven since the search began.
};

/// Whether corners choose the maps, because they are too many to be all searched: also in a region
/// that names no map.
[[nodiscard]] bool is_chosen_by_corners(MapSource& source,
                                        const std::optional<StartRegion>& region);

/// With six corners or more, maps whose best pose in the ranking is at most 0.2 nat per hit below
/// that of the best map, and at most 32. With fewer corners all maps if they are few enough, else
/// none.
[[nodiscard]] MapSelection select_maps(MapSource& source, const View& view,
                                       SelectionRequest request);

}  // namespace cornerfix

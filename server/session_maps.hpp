/// \file  The maps that a session's localizer needs in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <cornerfix/localization_map.hpp>
#include <cornerfix/result.hpp>

#include "server/map_library.hpp"

namespace cornerfix::server {

/// Maps in the order of a localizer, with their ids.
struct SessionMaps {
  std::vector<LocalizationMapPtr> maps;
  std::vector<std::int64_t> ids;
  bool holds_all = false;     ///< False: only one map is real, the others are stand-ins.
  double free_area_m2 = 0.0;  ///< Of all maps, as far as it is known.
};

/// What a search needs: every map, loaded one after the other. kConflict when they need more than
/// `max_bytes` together. A map that cannot be loaded is an error, or left out with a warning when
/// the session did not ask for it by name (`is_named` false).
[[nodiscard]] Result<SessionMaps> load_all(MapLibrary& library,
                                           std::span<const storage::MapInfo> infos,
                                           std::size_t max_bytes, bool is_named);

/// What tracking in one map needs: this map. The others are empty stand-ins, which together have
/// the free area of the others, since the decision on a pose weighs it.
[[nodiscard]] Result<SessionMaps> load_one(MapLibrary& library,
                                           std::span<const storage::MapInfo> infos, std::int64_t id,
                                           double free_area_m2);

}  // namespace cornerfix::server

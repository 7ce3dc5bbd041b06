/// \file  Whether a robot can be in the region where its session says that it is.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <cornerfix/localizer_params.hpp>
#include <cornerfix/result.hpp>

#include "server/map_library.hpp"

namespace cornerfix::server {

/// kInvalidArgument, in /near, when `region` names a map that is not searched, or lies outside all
/// that are. `searched` are the session's maps; empty: every map. A map without content may be
/// anywhere. O(maps) when every map is searched.
[[nodiscard]] Result<void> check_start_region(MapLibrary& library,
                                              const std::optional<StartRegion>& region,
                                              const std::vector<std::string>& searched);

}  // namespace cornerfix::server

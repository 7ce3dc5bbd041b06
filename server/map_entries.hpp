/// \file  What the services know of a map, as entries of documents.
#pragma once

#include <string_view>
#include <vector>

#include "api/json_codec.hpp"
#include "server/map_library.hpp"

namespace cornerfix::server {

/// Of MapLibrary::revisions(), whose first one is the present.
[[nodiscard]] api::Json revisions_of(std::string_view map,
                                     const std::vector<storage::MapRevision>& revisions);
/// Views of `info`, which must live longer.
[[nodiscard]] api::MapEntry entry_of(const storage::MapInfo& info);
/// Views of `report`, which must live longer.
[[nodiscard]] api::FloorMapResult entry_of(const FloorMapReport& report);

[[nodiscard]] api::MapBatchResult entry_of(const MapGrowthReport& report);

/// For what needs the grid of a map that is empty.
[[nodiscard]] Error map_without_grid();

}  // namespace cornerfix::server

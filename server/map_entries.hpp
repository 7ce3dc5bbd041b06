/// \file  What the services know of a map, as entries of documents.
#pragma once

#include <cstdint>
#include <string>
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

/// Names a map as it is: the strong entity tag of its entry.
[[nodiscard]] std::string map_entity_tag(std::uint64_t revision, std::string_view digest,
                                         std::string_view description);

/// For what needs the grid of a map that is empty.
[[nodiscard]] Error map_without_grid();

}  // namespace cornerfix::server

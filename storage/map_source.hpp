/// \file  The rows that are a map's source, and the revision made of them. For the sources of
/// MapStore. Functions throw as the tables do.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "storage/map_revisions.hpp"
#include "storage/map_tables.hpp"

namespace cornerfix::storage {

[[nodiscard]] Error unknown_map(std::string_view name);
[[nodiscard]] Error deleted_map();
[[nodiscard]] Error other_revision(std::uint64_t revision, std::uint64_t expected);

/// The map if it is still at `revision`.
[[nodiscard]] Result<MapRow> find_at_revision(MapTables& maps, std::int64_t id,
                                              std::uint64_t revision);

[[nodiscard]] Result<std::vector<PosedScan>> read_key_frames(MapTables& maps, const MapInfo& info);
/// Appends keyframes to the table and to the row's count and chain.
void append_key_frames(MapTables& maps, MapRow& map, std::span<const PosedScan> key_frames);

/// The map's whole source.
[[nodiscard]] Result<MapArchive> archive_of(MapTables& maps, const MapRow& map);
/// Gives a map without source that of an archive: rows, count, chain and whether it drifts.
void insert_source(MapTables& maps, MapRow& map, const MapArchive& archive);

/// For a map that has content.
void set_outline(MapInfo& info, const MapOutline& outline);
/// Gives the map's changed content its new revision and digest.
void seal_revision(MapRow& map, const RevisionChange& change);

}  // namespace cornerfix::storage

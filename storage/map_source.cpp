#include "storage/map_source.hpp"

#include <optional>
#include <string>
#include <utility>

#include "storage/blob_codec.hpp"
#include "storage/digest.hpp"

namespace cornerfix::storage {

Error unknown_map(std::string_view name) {
  return Error{ErrorCode::kNotFound, "there is no map named '" + std::string(name) + "'", "map"};
}

Error deleted_map() { return Error{ErrorCode::kNotFound, "the map has been deleted", "map"}; }

Error other_revision(std::uint64_t revision, std::uint64_t expected) {
  return Error{ErrorCode::kConflict,
               "the map is at revision " + std::to_string(revision) + ", expected " +
                   std::to_string(expected),
               "revision"};
}

Result<MapRow> find_at_revision(MapTables& maps, std::int64_t id, std::uint64_t revision) {
  std::optional<MapRow> map = maps.find(id);
  if (!map) return deleted_map();
  if (map->info.revision != revision) return other_revision(map->info.revision, revision);
  return std::move(*map);
}

Result<std::vector<PosedScan>> read_key_frames(MapTables& maps, const MapInfo& info) {
  std::vector<PosedScan> key_frames;
  key_frames.reserve(info.key_frame_count);
  std::optional<Error> damage;
  maps.read_key_frames(info.id, [&](BlobView blob) {
    Result<PosedScan> key_frame = decode_key_frame(blob);
    if (!key_frame) {
      damage = key_frame.error();
      return false;
    }
    key_frames.push_back(std::move(*key_frame));
    return true;
  });
  if (damage) return *damage;
  if (key_frames.size() != info.key_frame_count) {
    return Error{ErrorCode::kCorruptData,
                 "the map has " + std::to_string(key_frames.size()) + " key frames, expected " +
                     std::to_string(info.key_frame_count),
                 ""};
  }
  return key_frames;
}

void append_key_frames(MapTables& maps, MapRow& map, std::span<const PosedScan> key_frames) {
  for (const PosedScan& key_frame : key_frames) {
    const Blob blob = encode_key_frame(key_frame);
    maps.insert_key_frame(map.info.id, map.info.key_frame_count, blob);
    map.chain = extend(map.chain, blob);
    ++map.info.key_frame_count;
  }
}

Result<MapArchive> archive_of(MapTables& maps, const MapRow& map) {
  const MapInfo& info = map.info;
  MapArchive archive{.description = info.description,
                     .lidar_json = info.lidar_json,
                     .parameters_json = info.parameters_json,
                     .revision = info.revision,
                     .digest = info.digest,
                     .stamps = maps.stamps(info.id),
                     .key_frames = {},
                     .drifts = info.drifts,
                     .floor_map = {}};
  Result<std::vector<PosedScan>> key_frames = read_key_frames(maps, info);
  if (!key_frames) return key_frames.error();
  archive.key_frames = std::move(*key_frames);
  if (const std::optional<Blob> blob = maps.grid(info.id)) {
    Result<OccupancyGrid> grid = decode_grid(*blob);
    if (!grid) return grid.error();
    archive.floor_map = std::move(*grid);
  }
  return archive;
}

void insert_source(MapTables& maps, MapRow& map, const MapArchive& archive) {
  map.chain = {};
  map.info.key_frame_count = 0;
  map.info.drifts = archive.drifts;
  map.info.has_floor_map = archive.floor_map.has_value();
  maps.insert_stamps(map.info.id, archive.stamps);
  append_key_frames(maps, map, archive.key_frames);
  if (!archive.floor_map) return;
  map.chain = hash_of(*archive.floor_map);
  maps.put_grid(map.info.id, encode_grid(*archive.floor_map));
}

void set_outline(MapInfo& info, const MapOutline& outline) {
  info.feature_count = outline.feature_count;
  info.bounds = outline.bounds;
}

void seal_revision(MapRow& map, const RevisionChange& change) {
  ++map.info.revision;
  map.info.digest = map_digest(map.info.parameters_json, map.chain, map.info.drifts);
  map.info.revision_created = change.now;
  map.info.revision_origin = change.origin;
}

}  // namespace cornerfix::storage

#include "storage/map_store.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "storage/blob_codec.hpp"
#include "storage/database.hpp"
#include "storage/digest.hpp"
#include "storage/map_source.hpp"
#include "storage/map_tables.hpp"

namespace cornerfix::storage {
namespace {

Error made_from_floor_map() {
  return Error{ErrorCode::kConflict,
               "the map was made from a floor map and takes no scans; make another map of them",
               "map"};
}

/// Puts `value` in place of `stored`; false when that changes nothing or there is no value.
bool replace(std::string& stored, std::optional<std::string_view> value) {
  if (!value || stored == *value) return false;
  stored = *value;
  return true;
}

/// Writes all keyframes again; their number is that of before.
void rewrite_key_frames(MapTables& maps, MapRow& map, std::span<const PosedScan> key_frames) {
  map.chain = {};
  for (std::size_t ordinal = 0; ordinal < key_frames.size(); ++ordinal) {
    const Blob blob = encode_key_frame(key_frames[ordinal]);
    maps.replace_key_frame(map.info.id, ordinal, blob);
    map.chain = extend(map.chain, blob);
  }
}

/// Descriptors of a large map are made again from its features: that is as fast as reading them.
Blob encode_or_omit(const DescriptorSet& descriptors) {
  constexpr std::size_t kMostStored = std::size_t{4} << 20U;
  if (descriptors.entries.size() <= kMostStored) return encode_descriptors(descriptors);
  DescriptorSet omitted;
  omitted.params = descriptors.params;
  return encode_descriptors(omitted);
}

ContentBlobs encode_content(std::uint64_t revision, const MapContent& content) {
  return {.revision = revision,
          .features = encode_features(content.features),
          .descriptors = encode_or_omit(content.descriptors),
          .grid = encode_grid(content.grid)};
}

Result<MapContent> decode_content(const ContentBlobs& blobs) {
  Result<std::vector<Feature>> decoded_features = decode_features(blobs.features);
  if (!decoded_features) return decoded_features.error();
  Result<DescriptorSet> decoded_descriptors = decode_descriptors(blobs.descriptors);
  if (!decoded_descriptors) return decoded_descriptors.error();
  Result<OccupancyGrid> decoded_grid = decode_grid(blobs.grid);
  if (!decoded_grid) return decoded_grid.error();
  if (decoded_descriptors->size() == 0 && !decoded_features->empty()) {
    if (validate(decoded_descriptors->params)) {
      return Error{ErrorCode::kCorruptData, "descriptors: their parameters are wrong", ""};
    }
    *decoded_descriptors = describe(*decoded_features, decoded_descriptors->params);
  }
  if (decoded_descriptors->size() != decoded_features->size()) {
    return Error{ErrorCode::kCorruptData, "features and descriptors differ in number", ""};
  }
  return MapContent{std::move(*decoded_features), std::move(*decoded_descriptors),
                    std::move(*decoded_grid)};
}

}  // namespace

MapStore::MapStore(std::shared_ptr<Database> database, std::size_t kept_revisions)
    : database_(std::move(database)), kept_revisions_(kept_revisions) {}
MapStore::~MapStore() = default;
MapStore::MapStore(MapStore&&) noexcept = default;

Result<std::size_t> MapStore::count() {
  return guarded([&]() -> Result<std::size_t> { return database_->maps().count(); });
}

Result<std::vector<MapInfo>> MapStore::list(std::string_view after, std::size_t limit) {
  return guarded([&]() -> Result<std::vector<MapInfo>> {
    const std::vector<MapRow> rows = database_->maps().list(after, limit);
    std::vector<MapInfo> maps;
    maps.reserve(rows.size());
    for (const MapRow& row : rows) maps.push_back(row.info);
    return maps;
  });
}

Result<MapInfo> MapStore::find(std::string_view name) {
  return guarded([&]() -> Result<MapInfo> {
    std::optional<MapRow> map = database_->maps().find(name);
    if (!map) return unknown_map(name);
    return std::move(map->info);
  });
}

Result<bool> MapStore::put(std::string_view name, std::optional<std::string_view> description,
                           std::optional<std::string_view> lidar_json,
                           std::optional<std::string_view> parameters_json, std::string_view now,
                           const std::optional<MapRemake>& remake) {
  return guarded([&]() -> Result<bool> {
    const auto transaction = database_->begin(Access::kWrite);
    MapTables& maps = database_->maps();
    std::optional<MapRow> stored = maps.find(name);
    MapRow map = stored.value_or(MapRow{});
    if (remake) {
      if (const auto same = check_known(map.info, remake->known); !same) return same.error();
    }
    if (remake && map.info.bounds) set_outline(map.info, remake->outline);
    map.info.name = name;
    const bool described = replace(map.info.description, description);
    const bool other_lidar = replace(map.info.lidar_json, lidar_json);
    const bool other_parameters = replace(map.info.parameters_json, parameters_json);
    const bool is_other_content = other_lidar || other_parameters;
    if (stored && is_other_content) {
      const auto kept =
          keep_revision(maps, *stored, {RevisionOrigin::kSettings, now}, kept_revisions_);
      if (!kept) return kept.error();
    }
    if (is_other_content || !stored) seal_revision(map, {RevisionOrigin::kSettings, now});
    if (!stored) {
      map.info.created = map.info.updated = now;
      maps.insert(map);
    } else if (described || is_other_content) {
      map.info.updated = now;
      maps.update(map);
    }
    transaction->commit();
    return !stored.has_value();
  });
}

Result<void> MapStore::remove(std::string_view name, const std::optional<KnownMap>& known) {
  return guarded([&]() -> Result<void> {
    const auto transaction = database_->begin(Access::kWrite);
    MapTables& maps = database_->maps();
    const std::optional<MapRow> map = maps.find(name);
    if (!map) return unknown_map(name);
    if (known) {
      if (auto same = check_known(map->info, *known); !same) return same;
    }
    maps.remove(name);
    transaction->commit();
    return {};
  });
}

Result<std::vector<bool>> MapStore::known_stamps(std::int64_t map_id,
                                                 std::span<const double> stamps) {
  return guarded([&]() -> Result<std::vector<bool>> {
    const auto transaction = database_->begin(Access::kRead);
    return database_->maps().known_stamps(map_id, stamps);
  });
}

Result<MapInfo> MapStore::grow(std::int64_t map_id, std::uint64_t expected_revision,
                               const MapGrowth& growth, std::string_view now) {
  return guarded([&]() -> Result<MapInfo> {
    ContentBlobs content;
    if (growth.content != nullptr) content = encode_content(0, *growth.content);
    const auto transaction = database_->begin(Access::kWrite);
    MapTables& maps = database_->maps();
    Result<MapRow> map = find_at_revision(maps, map_id, expected_revision);
    if (!map) return map.error();
    if (map->info.has_floor_map) return made_from_floor_map();
    const RevisionChange change{RevisionOrigin::kScans, now};
    if (!growth.new_key_frames.empty()) {
      if (const auto kept = keep_revision(maps, *map, change, kept_revisions_); !kept)
        return kept.error();
    }
    maps.insert_stamps(map_id, growth.stamps);
    append_key_frames(maps, *map, growth.new_key_frames);
    MapInfo& info = map->info;
    if (info.key_frame_count > 0) set_outline(info, growth.outline);
    info.updated = now;
    if (!growth.new_key_frames.empty()) {
      info.drifts = growth.drifts;
      seal_revision(*map, change);
    }
    if (growth.content != nullptr) {
      info.feature_count = growth.content->features.size();
      content.revision = info.revision;
      maps.put_content(map_id, content);
    }
    if (growth.sketch != nullptr)
      maps.put_sketch({map_id, info.revision, encode_map_sketch(*growth.sketch)});
    maps.update(*map);
    transaction->commit();
    return std::move(info);
  });
}

Result<std::vector<PosedScan>> MapStore::key_frames(std::int64_t map_id) {
  return guarded([&]() -> Result<std::vector<PosedScan>> {
    const auto transaction = database_->begin(Access::kRead);
    MapTables& maps = database_->maps();
    const std::optional<MapRow> map = maps.find(map_id);
    if (!map) return deleted_map();
    return read_key_frames(maps, map->info);
  });
}

Result<MapInfo> MapStore::put_floor_map(std::string_view name, const FloorMap& floor_map,
                                        std::string_view now) {
  return guarded([&]() -> Result<MapInfo> {
    const KeyFrameChain hash = hash_of(floor_map.grid);
    const auto transaction = database_->begin(Access::kWrite);
    MapTables& maps = database_->maps();
    std::optional<MapRow> stored = maps.find(name);
    if (stored && (stored->info.key_frame_count > 0 || maps.holds_stamps(stored->info.id))) {
      return Error{ErrorCode::kConflict,
                   "the map is made of scans; delete it first, or give the floor map another name",
                   "map"};
    }
    MapRow map = stored.value_or(MapRow{});
    MapInfo& info = map.info;
    if (const auto same = check_known(info, floor_map.known); !same) return same.error();
    if (info.has_floor_map && map.chain == hash) return std::move(info);
    const RevisionChange change{RevisionOrigin::kOccupancyMap, now};
    if (stored) {
      if (const auto kept = keep_revision(maps, *stored, change, kept_revisions_); !kept)
        return kept.error();
    }
    info.name = name;
    map.chain = hash;
    set_outline(info, floor_map.outline);
    info.updated = now;
    seal_revision(map, change);
    if (!stored) {
      info.created = now;
      info.id = maps.insert(map);
    }
    maps.update(map);
    maps.put_grid(info.id, encode_grid(floor_map.grid));
    info.has_floor_map = true;
    transaction->commit();
    return std::move(info);
  });
}

Result<MapArchive> MapStore::archive(std::string_view name) {
  return guarded([&]() -> Result<MapArchive> {
    const auto transaction = database_->begin(Access::kRead);
    MapTables& maps = database_->maps();
    const std::optional<MapRow> map = maps.find(name);
    if (!map) return unknown_map(name);
    return archive_of(maps, *map);
  });
}

Result<MapInfo> MapStore::restore(std::string_view name, const MapArchive& archive,
                                  const MapOutline& outline, std::string_view now) {
  MapInfo info;
  set_outline(info, outline);
  info.name = name;
  info.created = info.updated = info.revision_created = now;
  info.revision_origin = RevisionOrigin::kArchive;
  return insert(std::move(info), archive);
}

Result<MapInfo> MapStore::insert(MapInfo info, const MapArchive& archive) {
  return guarded([&]() -> Result<MapInfo> {
    const auto transaction = database_->begin(Access::kWrite);
    MapTables& maps = database_->maps();
    if (maps.find(info.name)) {
      return Error{ErrorCode::kConflict,
                   "there is a map named '" + info.name +
                       "'; delete it first, or restore under another name",
                   "map"};
    }
    MapRow map{.info = std::move(info)};
    map.info.description = archive.description;
    map.info.lidar_json = archive.lidar_json;
    map.info.parameters_json = archive.parameters_json;
    map.info.revision = archive.revision;
    map.info.key_frame_count = 0;
    map.info.id = maps.insert(map);
    insert_source(maps, map, archive);
    map.info.digest = map_digest(archive.parameters_json, map.chain, archive.drifts);
    maps.update(map);
    transaction->commit();
    return std::move(map.info);
  });
}

Result<OccupancyGrid> MapStore::floor_map(std::int64_t map_id) {
  return guarded([&]() -> Result<OccupancyGrid> {
    const std::optional<Blob> grid = database_->maps().grid(map_id);
    if (grid) return decode_grid(*grid);
    return Error{ErrorCode::kNotFound, "the map was not made from a floor map", "map"};
  });
}

Result<MapInfo> MapStore::move_key_frames(std::int64_t map_id, std::uint64_t expected_revision,
                                          std::span<const Pose2> T_map_base_link,
                                          const MapOutline& outline, std::string_view now) {
  return guarded([&]() -> Result<MapInfo> {
    const auto transaction = database_->begin(Access::kWrite);
    MapTables& maps = database_->maps();
    Result<MapRow> map = find_at_revision(maps, map_id, expected_revision);
    if (!map) return map.error();
    const RevisionChange change{RevisionOrigin::kTrajectory, now};
    if (const auto kept = keep_revision(maps, *map, change, kept_revisions_); !kept)
      return kept.error();
    Result<std::vector<PosedScan>> key_frames = read_key_frames(maps, map->info);
    if (!key_frames) return key_frames.error();
    if (T_map_base_link.size() != key_frames->size()) {
      return Error{ErrorCode::kInvalidArgument,
                   std::to_string(T_map_base_link.size()) + " poses, expected one for each of " +
                       std::to_string(key_frames->size()) + " key frames",
                   "poses"};
    }
    for (std::size_t i = 0; i < key_frames->size(); ++i) {
      (*key_frames)[i].T_map_base_link = T_map_base_link[i];
    }
    const KeyFrameChain chain_before = map->chain;
    rewrite_key_frames(maps, *map, *key_frames);
    const bool drifted = std::exchange(map->info.drifts, false);
    if (!drifted && map->chain == chain_before) return std::move(map->info);  // Nothing has moved.
    if (!key_frames->empty()) set_outline(map->info, outline);
    map->info.updated = now;
    seal_revision(*map, change);
    maps.update(*map);
    transaction->commit();
    return std::move(map->info);
  });
}

Result<std::optional<StoredContent>> MapStore::content(std::int64_t map_id) {
  return guarded([&]() -> Result<std::optional<StoredContent>> {
    const std::optional<ContentBlobs> stored = database_->maps().content(map_id);
    if (!stored) return std::optional<StoredContent>();
    Result<MapContent> content = decode_content(*stored);
    if (!content) return content.error();
    return std::optional(StoredContent{stored->revision, std::move(*content)});
  });
}

Result<void> MapStore::store_content(std::int64_t map_id, std::uint64_t revision,
                                     const MapContent& content) {
  assert(content.descriptors.size() == content.features.size() && "a descriptor a feature");
  return guarded([&]() -> Result<void> {
    const ContentBlobs blobs = encode_content(revision, content);
    const auto transaction = database_->begin(Access::kWrite);
    MapTables& maps = database_->maps();
    const Result<MapRow> map = find_at_revision(maps, map_id, revision);
    if (!map) return {};  // The map has moved on: the content is of no use any more.
    maps.put_content(map_id, blobs);
    maps.set_feature_count(map_id, content.features.size());
    transaction->commit();
    return {};
  });
}

}  // namespace cornerfix::storage

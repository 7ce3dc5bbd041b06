#include "storage/map_store.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "storage/blob_codec.hpp"
#include "storage/database.hpp"
#include "storage/digest.hpp"
#include "storage/statement.hpp"

namespace cornerfix::storage {
namespace {

/// A map's row: its entry and what only this module needs.
struct MapRow {
  MapInfo info;
  KeyFrameChain chain{};
};

const std::string kSelectMap =
    "SELECT id, name, description, revision, digest, key_frame_count, feature_count, min_x, min_y, "
    "max_x, max_y, created, updated, lidar_json, parameters_json, key_frame_chain, "
    "EXISTS (SELECT 1 FROM map_grids WHERE map_id = maps.id), drifts FROM maps ";

std::optional<Bounds> read_bounds(const Statement& row) {
  if (row.is_null(7)) return std::nullopt;
  return Bounds{{row.real(7), row.real(8)}, {row.real(9), row.real(10)}};
}

MapRow read_map(const Statement& row) {
  MapRow map;
  map.info.id = row.integer(0);
  map.info.name = row.text(1);
  map.info.description = row.text(2);
  map.info.revision = row.number(3);
  map.info.digest = row.text(4);
  map.info.key_frame_count = row.number(5);
  map.info.feature_count = row.number(6);
  map.info.bounds = read_bounds(row);
  map.info.created = row.text(11);
  map.info.updated = row.text(12);
  map.info.lidar_json = row.text(13);
  map.info.parameters_json = row.text(14);
  const BlobView chain = row.blob(15);
  std::copy_n(chain.begin(), std::min(chain.size(), map.chain.size()), map.chain.begin());
  map.info.has_floor_map = row.integer(16) != 0;
  map.info.drifts = row.integer(17) != 0;
  return map;
}

std::optional<MapRow> find_map(Database& database, std::string_view name) {
  static const std::string sql = kSelectMap + "WHERE name = ?";
  Statement statement(database, sql);
  if (!statement.bind(name).step()) return std::nullopt;
  return read_map(statement);
}

std::optional<MapRow> find_map(Database& database, std::int64_t id) {
  static const std::string sql = kSelectMap + "WHERE id = ?";
  Statement statement(database, sql);
  if (!statement.bind(id).step()) return std::nullopt;
  return read_map(statement);
}

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

/// The map if it is still at `revision`.
Result<MapRow> find_at_revision(Database& database, std::int64_t id, std::uint64_t revision) {
  std::optional<MapRow> map = find_map(database, id);
  if (!map) return deleted_map();
  if (map->info.revision != revision) return other_revision(map->info.revision, revision);
  return std::move(*map);
}

void insert_map(Database& database, const MapRow& map) {
  const MapInfo& info = map.info;
  Statement(database,
            "INSERT INTO maps (name, description, revision, digest, key_frame_chain, "
            "key_frame_count, feature_count, created, updated, lidar_json, parameters_json) "
            "VALUES (?, ?, ?, ?, ?, 0, 0, ?, ?, ?, ?)")
      .bind(info.name, info.description, info.revision, info.digest, BlobView(map.chain),
            info.created, info.updated, info.lidar_json, info.parameters_json)
      .run();
}

void update_map(Database& database, const MapRow& map) {
  const MapInfo& info = map.info;
  const Bounds bounds = info.bounds.value_or(Bounds{});
  const auto bound = [&](double value) {
    return info.bounds ? std::optional(value) : std::nullopt;
  };
  Statement(database,
            "UPDATE maps SET description = ?, revision = ?, digest = ?, key_frame_chain = ?, "
            "key_frame_count = ?, feature_count = ?, min_x = ?, min_y = ?, max_x = ?, max_y = ?, "
            "updated = ?, lidar_json = ?, parameters_json = ?, drifts = ? WHERE id = ?")
      .bind(info.description, info.revision, info.digest, BlobView(map.chain), info.key_frame_count,
            info.feature_count, bound(bounds.min.x()), bound(bounds.min.y()), bound(bounds.max.x()),
            bound(bounds.max.y()), info.updated, info.lidar_json, info.parameters_json,
            std::int64_t{info.drifts ? 1 : 0}, info.id)
      .run();
}

Error made_from_floor_map() {
  return Error{ErrorCode::kConflict,
               "the map was made from a floor map and takes no scans; make another map of them",
               "map"};
}

/// Whether the map has taken any scan, keyframe or not.
bool holds_scans(Database& database, std::int64_t map_id) {
  Statement statement(database, "SELECT 1 FROM map_stamps WHERE map_id = ? LIMIT 1");
  return statement.bind(map_id).step();
}

/// Puts `value` in place of `stored`; false when that changes nothing or there is no value.
bool replace(std::string& stored, std::optional<std::string_view> value) {
  if (!value || stored == *value) return false;
  stored = *value;
  return true;
}

void insert_stamps(Database& database, std::int64_t map_id, std::span<const double> stamps) {
  Statement statement(database, "INSERT INTO map_stamps (map_id, stamp) VALUES (?, ?)");
  for (const double stamp : stamps) statement.bind(map_id, stamp).run();
}

/// Appends keyframes to the table and to the row's count and chain.
void append_key_frames(Database& database, MapRow& map, std::span<const PosedScan> key_frames) {
  Statement statement(database, "INSERT INTO key_frames (map_id, ordinal, scan) VALUES (?, ?, ?)");
  for (const PosedScan& key_frame : key_frames) {
    const Blob blob = encode_key_frame(key_frame);
    statement.bind(map.info.id, map.info.key_frame_count, BlobView(blob)).run();
    map.chain = extend(map.chain, blob);
    ++map.info.key_frame_count;
  }
}

void insert_floor_map(Database& database, std::int64_t map_id, const OccupancyGrid& floor_map) {
  const Blob blob = encode_grid(floor_map);
  Statement(database, "INSERT OR REPLACE INTO map_grids (map_id, grid) VALUES (?, ?)")
      .bind(map_id, BlobView(blob))
      .run();
}

/// Writes all keyframes again; their number is that of before.
void rewrite_key_frames(Database& database, MapRow& map, std::span<const PosedScan> key_frames) {
  Statement statement(database, "UPDATE key_frames SET scan = ? WHERE map_id = ? AND ordinal = ?");
  map.chain = {};
  for (std::size_t ordinal = 0; ordinal < key_frames.size(); ++ordinal) {
    const Blob blob = encode_key_frame(key_frames[ordinal]);
    statement.bind(BlobView(blob), map.info.id, ordinal).run();
    map.chain = extend(map.chain, blob);
  }
}

/// Gives the map's changed content its new revision and digest.
void seal_revision(MapRow& map) {
  ++map.info.revision;
  map.info.digest = map_digest(map.info.parameters_json, map.chain, map.info.drifts);
}

Result<std::vector<PosedScan>> read_key_frames(Database& database, const MapInfo& info) {
  Statement statement(database, "SELECT scan FROM key_frames WHERE map_id = ? ORDER BY ordinal");
  statement.bind(info.id);
  std::vector<PosedScan> key_frames;
  key_frames.reserve(info.key_frame_count);
  while (statement.step()) {
    Result<PosedScan> key_frame = decode_key_frame(statement.blob(0));
    if (!key_frame) return key_frame.error();
    key_frames.push_back(std::move(*key_frame));
  }
  if (key_frames.size() != info.key_frame_count) {
    return Error{ErrorCode::kCorruptData,
                 "the map has " + std::to_string(key_frames.size()) + " key frames, expected " +
                     std::to_string(info.key_frame_count),
                 ""};
  }
  return key_frames;
}

/// For a map that has content.
void set_outline(MapInfo& info, const MapOutline& outline) {
  info.feature_count = outline.feature_count;
  info.bounds = outline.bounds;
}

/// Descriptors of a large map are made again from its features: that is as fast as reading them.
Blob encode_or_omit(const DescriptorSet& descriptors) {
  constexpr std::size_t kMostStored = std::size_t{4} << 20U;
  if (descriptors.entries.size() <= kMostStored) return encode_descriptors(descriptors);
  DescriptorSet omitted;
  omitted.params = descriptors.params;
  return encode_descriptors(omitted);
}

Result<MapContent> decode_content(BlobView features, BlobView descriptors, BlobView grid) {
  Result<std::vector<Feature>> decoded_features = decode_features(features);
  if (!decoded_features) return decoded_features.error();
  Result<DescriptorSet> decoded_descriptors = decode_descriptors(descriptors);
  if (!decoded_descriptors) return decoded_descriptors.error();
  Result<OccupancyGrid> decoded_grid = decode_grid(grid);
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

MapStore::MapStore(std::shared_ptr<Database> database) : database_(std::move(database)) {}
MapStore::~MapStore() = default;
MapStore::MapStore(MapStore&&) noexcept = default;

Result<std::size_t> MapStore::count() {
  return guarded([&]() -> Result<std::size_t> {
    Statement row(*database_, "SELECT count(*) FROM maps");
    row.step();
    return static_cast<std::size_t>(row.number(0));
  });
}

Result<std::vector<MapInfo>> MapStore::list(std::string_view after, std::size_t limit) {
  return guarded([&]() -> Result<std::vector<MapInfo>> {
    static const std::string sql = kSelectMap + "WHERE name > ? ORDER BY name LIMIT ?";
    // SQLite reads a limit above its largest integer as none.
    Statement statement(*database_, sql);
    statement.bind(after, limit);
    std::vector<MapInfo> maps;
    while (statement.step()) maps.push_back(read_map(statement).info);
    return maps;
  });
}

Result<MapInfo> MapStore::find(std::string_view name) {
  return guarded([&]() -> Result<MapInfo> {
    std::optional<MapRow> map = find_map(*database_, name);
    if (!map) return unknown_map(name);
    return std::move(map->info);
  });
}

Result<bool> MapStore::put(std::string_view name, std::optional<std::string_view> description,
                           std::optional<std::string_view> lidar_json,
                           std::optional<std::string_view> parameters_json, std::string_view now,
                           const std::optional<MapRemake>& remake) {
  return guarded([&]() -> Result<bool> {
    WriteTransaction transaction(*database_);
    std::optional<MapRow> stored = find_map(*database_, name);
    MapRow map = stored.value_or(MapRow{});
    if (remake && remake->expected_revision != map.info.revision)
      return other_revision(map.info.revision, remake->expected_revision);
    if (remake && map.info.bounds) set_outline(map.info, remake->outline);
    map.info.name = name;
    const bool described = replace(map.info.description, description);
    const bool other_lidar = replace(map.info.lidar_json, lidar_json);
    const bool other_parameters = replace(map.info.parameters_json, parameters_json);
    if (other_lidar || other_parameters || !stored) seal_revision(map);
    if (!stored) {
      map.info.created = map.info.updated = now;
      insert_map(*database_, map);
    } else if (described || other_lidar || other_parameters) {
      map.info.updated = now;
      update_map(*database_, map);
    }
    transaction.commit();
    return !stored.has_value();
  });
}

Result<void> MapStore::remove(std::string_view name) {
  return guarded([&]() -> Result<void> {
    WriteTransaction transaction(*database_);
    const int removed = Statement(*database_, "DELETE FROM maps WHERE name = ?").bind(name).run();
    transaction.commit();
    if (removed == 0) return unknown_map(name);
    return {};
  });
}

Result<std::vector<bool>> MapStore::known_stamps(std::int64_t map_id,
                                                 std::span<const double> stamps) {
  return guarded([&]() -> Result<std::vector<bool>> {
    ReadTransaction transaction(*database_);
    Statement statement(*database_, "SELECT 1 FROM map_stamps WHERE map_id = ? AND stamp = ?");
    std::vector<bool> known;
    known.reserve(stamps.size());
    for (const double stamp : stamps) known.push_back(statement.bind(map_id, stamp).step());
    return known;
  });
}

Result<MapInfo> MapStore::grow(std::int64_t map_id, std::uint64_t expected_revision,
                               const MapGrowth& growth, std::string_view now) {
  return guarded([&]() -> Result<MapInfo> {
    WriteTransaction transaction(*database_);
    Result<MapRow> map = find_at_revision(*database_, map_id, expected_revision);
    if (!map) return map.error();
    if (map->info.has_floor_map) return made_from_floor_map();
    insert_stamps(*database_, map_id, growth.stamps);
    append_key_frames(*database_, *map, growth.new_key_frames);
    MapInfo& info = map->info;
    if (info.key_frame_count > 0) set_outline(info, growth.outline);
    info.updated = now;
    if (!growth.new_key_frames.empty()) {
      info.drifts = growth.drifts;
      seal_revision(*map);
    }
    update_map(*database_, *map);
    transaction.commit();
    return std::move(info);
  });
}

Result<std::vector<PosedScan>> MapStore::key_frames(std::int64_t map_id) {
  return guarded([&]() -> Result<std::vector<PosedScan>> {
    ReadTransaction transaction(*database_);
    const std::optional<MapRow> map = find_map(*database_, map_id);
    if (!map) return deleted_map();
    return read_key_frames(*database_, map->info);
  });
}

Result<MapInfo> MapStore::put_floor_map(std::string_view name, const FloorMap& floor_map,
                                        std::string_view now) {
  return guarded([&]() -> Result<MapInfo> {
    const KeyFrameChain hash = hash_of(floor_map.grid);
    WriteTransaction transaction(*database_);
    std::optional<MapRow> stored = find_map(*database_, name);
    if (stored && (stored->info.key_frame_count > 0 || holds_scans(*database_, stored->info.id))) {
      return Error{ErrorCode::kConflict,
                   "the map is made of scans; delete it first, or give the floor map another name",
                   "map"};
    }
    MapRow map = stored.value_or(MapRow{});
    MapInfo& info = map.info;
    if (info.revision != floor_map.expected_revision)
      return other_revision(info.revision, floor_map.expected_revision);
    if (info.has_floor_map && map.chain == hash) return std::move(info);
    info.name = name;
    map.chain = hash;
    set_outline(info, floor_map.outline);
    info.updated = now;
    seal_revision(map);
    if (!stored) {
      info.created = now;
      insert_map(*database_, map);
      info.id = find_map(*database_, name)->info.id;
    }
    update_map(*database_, map);
    insert_floor_map(*database_, info.id, floor_map.grid);
    info.has_floor_map = true;
    transaction.commit();
    return std::move(info);
  });
}

Result<MapArchive> MapStore::archive(std::string_view name) {
  return guarded([&]() -> Result<MapArchive> {
    ReadTransaction transaction(*database_);
    const std::optional<MapRow> map = find_map(*database_, name);
    if (!map) return unknown_map(name);
    const MapInfo& info = map->info;
    MapArchive archive{.description = info.description,
                       .lidar_json = info.lidar_json,
                       .parameters_json = info.parameters_json,
                       .revision = info.revision,
                       .digest = info.digest,
                       .stamps = {},
                       .key_frames = {},
                       .drifts = info.drifts,
                       .floor_map = {}};
    Result<std::vector<PosedScan>> key_frames = read_key_frames(*database_, info);
    if (!key_frames) return key_frames.error();
    archive.key_frames = std::move(*key_frames);
    Statement stamps(*database_, "SELECT stamp FROM map_stamps WHERE map_id = ? ORDER BY stamp");
    for (stamps.bind(info.id); stamps.step();) archive.stamps.push_back(stamps.real(0));
    if (info.has_floor_map) {
      Result<OccupancyGrid> grid = floor_map(info.id);
      if (!grid) return grid.error();
      archive.floor_map = std::move(*grid);
    }
    return archive;
  });
}

Result<MapInfo> MapStore::restore(std::string_view name, const MapArchive& archive,
                                  const MapOutline& outline, std::string_view now) {
  return guarded([&]() -> Result<MapInfo> {
    WriteTransaction transaction(*database_);
    if (find_map(*database_, name)) {
      return Error{ErrorCode::kConflict,
                   "there is a map named '" + std::string(name) +
                       "'; delete it first, or restore under another name",
                   "map"};
    }
    MapRow map;
    set_outline(map.info, outline);
    map.info.name = name;
    map.info.description = archive.description;
    map.info.lidar_json = archive.lidar_json;
    map.info.parameters_json = archive.parameters_json;
    map.info.revision = archive.revision;
    map.info.drifts = archive.drifts;
    map.info.created = map.info.updated = now;
    insert_map(*database_, map);
    map.info.id = find_map(*database_, name)->info.id;
    insert_stamps(*database_, map.info.id, archive.stamps);
    append_key_frames(*database_, map, archive.key_frames);
    if (archive.floor_map) {
      map.info.has_floor_map = true;
      map.chain = hash_of(*archive.floor_map);
      insert_floor_map(*database_, map.info.id, *archive.floor_map);
    }
    map.info.digest = map_digest(archive.parameters_json, map.chain, archive.drifts);
    update_map(*database_, map);
    transaction.commit();
    return std::move(map.info);
  });
}

Result<OccupancyGrid> MapStore::floor_map(std::int64_t map_id) {
  return guarded([&]() -> Result<OccupancyGrid> {
    Statement statement(*database_, "SELECT grid FROM map_grids WHERE map_id = ?");
    if (!statement.bind(map_id).step()) {
      return Error{ErrorCode::kNotFound, "the map was not made from a floor map", "map"};
    }
    return decode_grid(statement.blob(0));
  });
}

Result<MapInfo> MapStore::move_key_frames(std::int64_t map_id, std::uint64_t expected_revision,
                                          std::span<const Pose2> T_map_base_link,
                                          const MapOutline& outline, std::string_view now) {
  return guarded([&]() -> Result<MapInfo> {
    WriteTransaction transaction(*database_);
    Result<MapRow> map = find_at_revision(*database_, map_id, expected_revision);
    if (!map) return map.error();
    Result<std::vector<PosedScan>> key_frames = read_key_frames(*database_, map->info);
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
    rewrite_key_frames(*database_, *map, *key_frames);
    const bool drifted = std::exchange(map->info.drifts, false);
    if (!drifted && map->chain == chain_before) return std::move(map->info);  // Nothing has moved.
    if (!key_frames->empty()) set_outline(map->info, outline);
    map->info.updated = now;
    seal_revision(*map);
    update_map(*database_, *map);
    transaction.commit();
    return std::move(map->info);
  });
}

Result<std::optional<StoredContent>> MapStore::content(std::int64_t map_id) {
  return guarded([&]() -> Result<std::optional<StoredContent>> {
    Statement statement(
        *database_,
        "SELECT revision, features, descriptors, grid FROM map_contents WHERE map_id = ?");
    if (!statement.bind(map_id).step()) return std::optional<StoredContent>();
    Result<MapContent> content =
        decode_content(statement.blob(1), statement.blob(2), statement.blob(3));
    if (!content) return content.error();
    return std::optional(StoredContent{statement.number(0), std::move(*content)});
  });
}

Result<void> MapStore::store_content(std::int64_t map_id, std::uint64_t revision,
                                     const MapContent& content) {
  assert(content.descriptors.size() == content.features.size() && "a descriptor a feature");
  return guarded([&]() -> Result<void> {
    const Blob features = encode_features(content.features);
    const Blob descriptors = encode_or_omit(content.descriptors);
    const Blob grid = encode_grid(content.grid);
    WriteTransaction transaction(*database_);
    const Result<MapRow> map = find_at_revision(*database_, map_id, revision);
    if (!map) return {};  // The map has moved on: the content is of no use any more.
    Statement(*database_,
              "INSERT OR REPLACE INTO map_contents (map_id, revision, features, descriptors, grid) "
              "VALUES (?, ?, ?, ?, ?)")
        .bind(map_id, revision, BlobView(features), BlobView(descriptors), BlobView(grid))
        .run();
    Statement(*database_, "UPDATE maps SET feature_count = ? WHERE id = ?")
        .bind(content.features.size(), map_id)
        .run();
    transaction.commit();
    return {};
  });
}

}  // namespace cornerfix::storage

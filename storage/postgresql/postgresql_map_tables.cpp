#include <algorithm>
#include <limits>
#include <string>

#include "storage/postgresql/postgresql_connection.hpp"
#include "storage/postgresql/postgresql_tables.hpp"

namespace cornerfix::storage {
namespace {

const std::string kSelectMaps =
    "SELECT id, name, description, revision, digest, key_frame_count, feature_count, min_x, min_y, "
    "max_x, max_y, created, updated, lidar_json, parameters_json, key_frame_chain, "
    "EXISTS (SELECT 1 FROM map_grids WHERE map_id = maps.id), drifts, "
    "revision_created, revision_origin FROM maps ";

/// Keyframes that are read in one round trip.
constexpr std::int64_t kKeyFramesPerRead = 500;

BlobView utf8_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

MapRow read_map_row(const PostgresqlRows& rows, int row) {
  MapRow map;
  map.info.id = rows.integer(row, 0);
  map.info.name = rows.text(row, 1);
  map.info.description = rows.text(row, 2);
  map.info.revision = rows.number(row, 3);
  map.info.digest = rows.text(row, 4);
  map.info.key_frame_count = rows.number(row, 5);
  map.info.feature_count = rows.number(row, 6);
  if (!rows.is_null(row, 7)) {
    map.info.bounds =
        Bounds{{rows.real(row, 7), rows.real(row, 8)}, {rows.real(row, 9), rows.real(row, 10)}};
  }
  map.info.created = rows.text(row, 11);
  map.info.updated = rows.text(row, 12);
  map.info.lidar_json = rows.text(row, 13);
  map.info.parameters_json = rows.text(row, 14);
  const BlobView chain = rows.blob(row, 15);
  std::copy_n(chain.begin(), std::min(chain.size(), map.chain.size()), map.chain.begin());
  map.info.has_floor_map = rows.boolean(row, 16);
  map.info.drifts = rows.boolean(row, 17);
  map.info.revision_created = rows.text(row, 18);
  map.info.revision_origin = revision_origin_from(rows.text(row, 19));
  return map;
}

class PostgresqlMapTables : public MapTables {
 public:
  explicit PostgresqlMapTables(PostgresqlConnection& connection) : connection_(connection) {}

  std::size_t count() override {
    return static_cast<std::size_t>(connection_.execute("SELECT count(*) FROM maps").number(0, 0));
  }

  std::vector<MapRow> list(std::string_view after, std::size_t limit) override {
    static const std::string sql = kSelectMaps + "WHERE name > $1 ORDER BY name LIMIT $2";
    constexpr std::size_t kMost = std::numeric_limits<std::int64_t>::max();
    const PostgresqlRows rows = connection_.execute(sql.c_str(), after, std::min(limit, kMost));
    std::vector<MapRow> maps;
    maps.reserve(static_cast<std::size_t>(rows.size()));
    for (int row = 0; row < rows.size(); ++row) maps.push_back(read_map_row(rows, row));
    return maps;
  }

  std::optional<MapRow> find(std::string_view name) override {
    static const std::string sql = kSelectMaps + "WHERE name = $1";
    return first(sql, name);
  }

  std::optional<MapRow> find(std::int64_t id) override {
    static const std::string sql = kSelectMaps + "WHERE id = $1";
    return first(sql, id);
  }

  std::int64_t insert(const MapRow& map) override {
    const MapInfo& info = map.info;
    const PostgresqlRows rows = connection_.execute(
        "INSERT INTO maps (id, name, description, revision, digest, key_frame_chain, "
        "key_frame_count, feature_count, created, updated, lidar_json, parameters_json, drifts, "
        "revision_created, revision_origin) "
        "VALUES (coalesce(nullif($1, 0), nextval('maps_id_seq')), $2, $3, $4, $5, $6, 0, 0, $7, "
        "$8, $9, $10, false, $11, $12) RETURNING id",
        info.id, info.name, utf8_bytes(info.description), info.revision, info.digest,
        BlobView(map.chain), info.created, info.updated, info.lidar_json, info.parameters_json,
        info.revision_created, to_string(info.revision_origin));
    return rows.integer(0, 0);
  }

  void update(const MapRow& map) override {
    const MapInfo& info = map.info;
    const Bounds bounds = info.bounds.value_or(Bounds{});
    const auto bound = [&](double value) {
      return info.bounds ? std::optional(value) : std::nullopt;
    };
    (void)connection_.execute(
        "UPDATE maps SET description = $1, revision = $2, digest = $3, key_frame_chain = $4, "
        "key_frame_count = $5, feature_count = $6, min_x = $7, min_y = $8, max_x = $9, "
        "max_y = $10, updated = $11, lidar_json = $12, parameters_json = $13, drifts = $14, "
        "revision_created = $15, revision_origin = $16 WHERE id = $17",
        utf8_bytes(info.description), info.revision, info.digest, BlobView(map.chain),
        info.key_frame_count, info.feature_count, bound(bounds.min.x()), bound(bounds.min.y()),
        bound(bounds.max.x()), bound(bounds.max.y()), info.updated, info.lidar_json,
        info.parameters_json, info.drifts, info.revision_created, to_string(info.revision_origin),
        info.id);
  }

  void remove(std::string_view name) override {
    (void)connection_.execute("DELETE FROM maps WHERE name = $1", name);
  }

  std::vector<bool> known_stamps(std::int64_t map, std::span<const double> stamps) override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT EXISTS (SELECT 1 FROM map_stamps WHERE map_id = $1 AND stamp = asked.stamp) "
        "FROM unnest($2) WITH ORDINALITY AS asked (stamp, place) ORDER BY asked.place",
        map, stamps);
    std::vector<bool> known;
    known.reserve(stamps.size());
    for (int row = 0; row < rows.size(); ++row) known.push_back(rows.boolean(row, 0));
    return known;
  }

  bool holds_stamps(std::int64_t map) override {
    return connection_.execute("SELECT EXISTS (SELECT 1 FROM map_stamps WHERE map_id = $1)", map)
        .boolean(0, 0);
  }

  std::vector<double> stamps(std::int64_t map) override {
    const PostgresqlRows rows =
        connection_.execute("SELECT stamp FROM map_stamps WHERE map_id = $1 ORDER BY stamp", map);
    std::vector<double> stamps;
    stamps.reserve(static_cast<std::size_t>(rows.size()));
    for (int row = 0; row < rows.size(); ++row) stamps.push_back(rows.real(row, 0));
    return stamps;
  }

  void insert_stamps(std::int64_t map, std::span<const double> stamps) override {
    (void)connection_.execute(
        "INSERT INTO map_stamps (map_id, stamp) SELECT $1, stamp FROM unnest($2) AS given (stamp)",
        map, stamps);
  }

  void read_key_frames(std::int64_t map, const std::function<bool(BlobView)>& use) override {
    std::int64_t last = -1;
    for (;;) {
      const PostgresqlRows rows = connection_.execute(
          "SELECT ordinal, scan FROM key_frames WHERE map_id = $1 AND ordinal > $2 "
          "ORDER BY ordinal LIMIT $3",
          map, last, kKeyFramesPerRead);
      for (int row = 0; row < rows.size(); ++row) {
        if (!use(rows.blob(row, 1))) return;
        last = rows.integer(row, 0);
      }
      if (rows.size() < kKeyFramesPerRead) return;
    }
  }

  void insert_key_frame(std::int64_t map, std::size_t ordinal, BlobView scan) override {
    (void)connection_.execute("INSERT INTO key_frames (map_id, ordinal, scan) VALUES ($1, $2, $3)",
                              map, ordinal, scan);
  }

  void replace_key_frame(std::int64_t map, std::size_t ordinal, BlobView scan) override {
    (void)connection_.execute("UPDATE key_frames SET scan = $1 WHERE map_id = $2 AND ordinal = $3",
                              scan, map, ordinal);
  }

  std::optional<Blob> grid(std::int64_t map) override {
    const PostgresqlRows rows =
        connection_.execute("SELECT grid FROM map_grids WHERE map_id = $1", map);
    if (rows.empty()) return std::nullopt;
    return rows.copy(0, 0);
  }

  void put_grid(std::int64_t map, BlobView grid) override {
    (void)connection_.execute(
        "INSERT INTO map_grids (map_id, grid) VALUES ($1, $2) "
        "ON CONFLICT (map_id) DO UPDATE SET grid = excluded.grid",
        map, grid);
  }

  void remove_source(std::int64_t map) override {
    for (const char* sql :
         {"DELETE FROM key_frames WHERE map_id = $1", "DELETE FROM map_stamps WHERE map_id = $1",
          "DELETE FROM map_grids WHERE map_id = $1"})
      (void)connection_.execute(sql, map);
  }

  std::vector<MapRevision> kept_revisions(std::int64_t map) override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT revision, digest, created, origin, feature_count, octet_length(archive)::bigint "
        "FROM map_revisions WHERE map_id = $1 ORDER BY revision DESC",
        map);
    std::vector<MapRevision> revisions;
    revisions.reserve(static_cast<std::size_t>(rows.size()));
    for (int row = 0; row < rows.size(); ++row) {
      revisions.push_back({.revision = rows.number(row, 0),
                           .digest = rows.text(row, 1),
                           .created = rows.text(row, 2),
                           .origin = revision_origin_from(rows.text(row, 3)),
                           .feature_count = rows.number(row, 4),
                           .archive_bytes = rows.number(row, 5)});
    }
    return revisions;
  }

  std::optional<Blob> revision_archive(std::int64_t map, std::uint64_t revision) override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT archive FROM map_revisions WHERE map_id = $1 AND revision = $2", map, revision);
    if (rows.empty()) return std::nullopt;
    return rows.copy(0, 0);
  }

  void insert_revision(std::int64_t map, const MapRevision& revision, BlobView archive) override {
    (void)connection_.execute(
        "INSERT INTO map_revisions (map_id, revision, digest, created, origin, feature_count, "
        "archive) VALUES ($1, $2, $3, $4, $5, $6, $7)",
        map, revision.revision, revision.digest, revision.created, to_string(revision.origin),
        revision.feature_count, archive);
  }

  void remove_old_revisions(std::int64_t map, std::size_t kept) override {
    (void)connection_.execute(
        "DELETE FROM map_revisions WHERE map_id = $1 AND revision NOT IN (SELECT revision "
        "FROM map_revisions WHERE map_id = $1 ORDER BY revision DESC LIMIT $2)",
        map, kept);
  }

  std::optional<ContentBlobs> content(std::int64_t map) override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT revision, features, descriptors, grid FROM map_contents WHERE map_id = $1", map);
    if (rows.empty()) return std::nullopt;
    return ContentBlobs{.revision = rows.number(0, 0),
                        .features = rows.copy(0, 1),
                        .descriptors = rows.copy(0, 2),
                        .grid = rows.copy(0, 3)};
  }

  void put_content(std::int64_t map, const ContentBlobs& content) override {
    (void)connection_.execute(
        "INSERT INTO map_contents (map_id, revision, features, descriptors, grid) "
        "VALUES ($1, $2, $3, $4, $5) ON CONFLICT (map_id) DO UPDATE SET "
        "revision = excluded.revision, features = excluded.features, "
        "descriptors = excluded.descriptors, grid = excluded.grid",
        map, content.revision, BlobView(content.features), BlobView(content.descriptors),
        BlobView(content.grid));
  }

  std::vector<SketchState> sketch_states() override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT id, name, maps.revision, min_x IS NOT NULL, coalesce(map_sketches.revision, 0) "
        "FROM maps LEFT JOIN map_sketches ON map_id = id ORDER BY id");
    std::vector<SketchState> states;
    states.reserve(static_cast<std::size_t>(rows.size()));
    for (int row = 0; row < rows.size(); ++row) {
      states.push_back({.id = rows.integer(row, 0),
                        .name = rows.text(row, 1),
                        .revision = rows.number(row, 2),
                        .has_content = rows.boolean(row, 3),
                        .sketch_revision = rows.number(row, 4)});
    }
    return states;
  }

  std::vector<SketchRow> sketches(std::int64_t after, std::size_t limit) override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT map_id, revision, sketch FROM map_sketches WHERE map_id > $1 "
        "ORDER BY map_id LIMIT $2",
        after, limit);
    std::vector<SketchRow> sketches;
    sketches.reserve(static_cast<std::size_t>(rows.size()));
    for (int row = 0; row < rows.size(); ++row) {
      sketches.push_back({.map = rows.integer(row, 0),
                          .revision = rows.number(row, 1),
                          .sketch = rows.copy(row, 2)});
    }
    return sketches;
  }

  void put_sketch(const SketchRow& row) override {
    (void)connection_.execute(
        "INSERT INTO map_sketches (map_id, revision, sketch) VALUES ($1, $2, $3) "
        "ON CONFLICT (map_id) DO UPDATE SET revision = excluded.revision, "
        "sketch = excluded.sketch",
        row.map, row.revision, BlobView(row.sketch));
  }

  void set_feature_count(std::int64_t map, std::size_t count) override {
    (void)connection_.execute("UPDATE maps SET feature_count = $1 WHERE id = $2", count, map);
  }

 private:
  template <typename Key>
  std::optional<MapRow> first(const std::string& sql, Key key) {
    const char* lock = connection_.is_writing() ? " FOR UPDATE OF maps" : "";
    const PostgresqlRows rows = connection_.execute((sql + lock).c_str(), key);
    if (rows.empty()) return std::nullopt;
    return read_map_row(rows, 0);
  }

  PostgresqlConnection& connection_;
};

}  // namespace

std::unique_ptr<MapTables> make_map_tables(PostgresqlConnection& connection) {
  return std::make_unique<PostgresqlMapTables>(connection);
}

}  // namespace cornerfix::storage

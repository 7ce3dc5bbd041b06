#include <algorithm>
#include <string>

#include "storage/sqlite/sqlite_tables.hpp"
#include "storage/sqlite/statement.hpp"

namespace cornerfix::storage {
namespace {

const std::string kSelectMap =
    "SELECT id, name, description, revision, digest, key_frame_count, feature_count, min_x, min_y, "
    "max_x, max_y, created, updated, lidar_json, parameters_json, key_frame_chain, "
    "EXISTS (SELECT 1 FROM map_grids WHERE map_id = maps.id), drifts, "
    "revision_created, revision_origin FROM maps ";

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
  map.info.revision_created = row.text(18);
  map.info.revision_origin = revision_origin_from(row.text(19));
  return map;
}

Blob copy_of(BlobView blob) { return {blob.begin(), blob.end()}; }

class SqliteMapTables : public MapTables {
 public:
  explicit SqliteMapTables(SqliteDatabase& database) : database_(database) {}

  std::size_t count() override {
    Statement row(database_, "SELECT count(*) FROM maps");
    row.step();
    return static_cast<std::size_t>(row.number(0));
  }

  std::vector<MapRow> list(std::string_view after, std::size_t limit) override {
    static const std::string sql = kSelectMap + "WHERE name > ? ORDER BY name LIMIT ?";
    // SQLite reads a limit above its largest integer as none.
    Statement statement(database_, sql);
    statement.bind(after, limit);
    std::vector<MapRow> maps;
    while (statement.step()) maps.push_back(read_map(statement));
    return maps;
  }

  std::optional<MapRow> find(std::string_view name) override {
    static const std::string sql = kSelectMap + "WHERE name = ?";
    Statement statement(database_, sql);
    if (!statement.bind(name).step()) return std::nullopt;
    return read_map(statement);
  }

  std::optional<MapRow> find(std::int64_t id) override {
    static const std::string sql = kSelectMap + "WHERE id = ?";
    Statement statement(database_, sql);
    if (!statement.bind(id).step()) return std::nullopt;
    return read_map(statement);
  }

  std::int64_t insert(const MapRow& map) override {
    const MapInfo& info = map.info;
    Statement(database_,
              "INSERT INTO maps (id, name, description, revision, digest, key_frame_chain, "
              "key_frame_count, feature_count, created, updated, lidar_json, parameters_json, "
              "revision_created, revision_origin) "
              "VALUES (nullif(?, 0), ?, ?, ?, ?, ?, 0, 0, ?, ?, ?, ?, ?, ?)")
        .bind(info.id, info.name, info.description, info.revision, info.digest, BlobView(map.chain),
              info.created, info.updated, info.lidar_json, info.parameters_json,
              info.revision_created, to_string(info.revision_origin))
        .run();
    return database_.last_row_id();
  }

  void update(const MapRow& map) override {
    const MapInfo& info = map.info;
    const Bounds bounds = info.bounds.value_or(Bounds{});
    const auto bound = [&](double value) {
      return info.bounds ? std::optional(value) : std::nullopt;
    };
    Statement(database_,
              "UPDATE maps SET description = ?, revision = ?, digest = ?, key_frame_chain = ?, "
              "key_frame_count = ?, feature_count = ?, min_x = ?, min_y = ?, max_x = ?, max_y = ?, "
              "updated = ?, lidar_json = ?, parameters_json = ?, drifts = ?, "
              "revision_created = ?, revision_origin = ? WHERE id = ?")
        .bind(info.description, info.revision, info.digest, BlobView(map.chain),
              info.key_frame_count, info.feature_count, bound(bounds.min.x()),
              bound(bounds.min.y()), bound(bounds.max.x()), bound(bounds.max.y()), info.updated,
              info.lidar_json, info.parameters_json, std::int64_t{info.drifts ? 1 : 0},
              info.revision_created, to_string(info.revision_origin), info.id)
        .run();
  }

  void remove(std::string_view name) override {
    Statement(database_, "DELETE FROM maps WHERE name = ?").bind(name).run();
  }

  std::vector<bool> known_stamps(std::int64_t map, std::span<const double> stamps) override {
    Statement statement(database_, "SELECT 1 FROM map_stamps WHERE map_id = ? AND stamp = ?");
    std::vector<bool> known;
    known.reserve(stamps.size());
    for (const double stamp : stamps) known.push_back(statement.bind(map, stamp).step());
    return known;
  }

  bool holds_stamps(std::int64_t map) override {
    Statement statement(database_, "SELECT 1 FROM map_stamps WHERE map_id = ? LIMIT 1");
    return statement.bind(map).step();
  }

  std::vector<double> stamps(std::int64_t map) override {
    Statement statement(database_, "SELECT stamp FROM map_stamps WHERE map_id = ? ORDER BY stamp");
    std::vector<double> stamps;
    for (statement.bind(map); statement.step();) stamps.push_back(statement.real(0));
    return stamps;
  }

  void insert_stamps(std::int64_t map, std::span<const double> stamps) override {
    Statement statement(database_, "INSERT INTO map_stamps (map_id, stamp) VALUES (?, ?)");
    for (const double stamp : stamps) statement.bind(map, stamp).run();
  }

  void read_key_frames(std::int64_t map, const std::function<bool(BlobView)>& use) override {
    Statement statement(database_, "SELECT scan FROM key_frames WHERE map_id = ? ORDER BY ordinal");
    for (statement.bind(map); statement.step() && use(statement.blob(0));) {
    }
  }

  void insert_key_frame(std::int64_t map, std::size_t ordinal, BlobView scan) override {
    Statement(database_, "INSERT INTO key_frames (map_id, ordinal, scan) VALUES (?, ?, ?)")
        .bind(map, ordinal, scan)
        .run();
  }

  void replace_key_frame(std::int64_t map, std::size_t ordinal, BlobView scan) override {
    Statement(database_, "UPDATE key_frames SET scan = ? WHERE map_id = ? AND ordinal = ?")
        .bind(scan, map, ordinal)
        .run();
  }

  std::optional<Blob> grid(std::int64_t map) override {
    Statement statement(database_, "SELECT grid FROM map_grids WHERE map_id = ?");
    if (!statement.bind(map).step()) return std::nullopt;
    return copy_of(statement.blob(0));
  }

  void put_grid(std::int64_t map, BlobView grid) override {
    Statement(database_, "INSERT OR REPLACE INTO map_grids (map_id, grid) VALUES (?, ?)")
        .bind(map, grid)
        .run();
  }

  void remove_source(std::int64_t map) override {
    for (const char* sql :
         {"DELETE FROM key_frames WHERE map_id = ?", "DELETE FROM map_stamps WHERE map_id = ?",
          "DELETE FROM map_grids WHERE map_id = ?"})
      Statement(database_, sql).bind(map).run();
  }

  std::vector<MapRevision> kept_revisions(std::int64_t map) override {
    Statement row(database_,
                  "SELECT revision, digest, created, origin, feature_count, length(archive) "
                  "FROM map_revisions WHERE map_id = ? ORDER BY revision DESC");
    std::vector<MapRevision> revisions;
    for (row.bind(map); row.step();) {
      revisions.push_back({.revision = row.number(0),
                           .digest = row.text(1),
                           .created = row.text(2),
                           .origin = revision_origin_from(row.text(3)),
                           .feature_count = row.number(4),
                           .archive_bytes = row.number(5)});
    }
    return revisions;
  }

  std::optional<Blob> revision_archive(std::int64_t map, std::uint64_t revision) override {
    Statement row(database_, "SELECT archive FROM map_revisions WHERE map_id = ? AND revision = ?");
    if (!row.bind(map, revision).step()) return std::nullopt;
    return copy_of(row.blob(0));
  }

  void insert_revision(std::int64_t map, const MapRevision& revision, BlobView archive) override {
    Statement(database_,
              "INSERT INTO map_revisions (map_id, revision, digest, created, origin, "
              "feature_count, archive) VALUES (?, ?, ?, ?, ?, ?, ?)")
        .bind(map, revision.revision, revision.digest, revision.created, to_string(revision.origin),
              revision.feature_count, archive)
        .run();
  }

  void remove_old_revisions(std::int64_t map, std::size_t kept) override {
    Statement(database_,
              "DELETE FROM map_revisions WHERE map_id = ? AND revision NOT IN (SELECT revision "
              "FROM map_revisions WHERE map_id = ? ORDER BY revision DESC LIMIT ?)")
        .bind(map, map, kept)
        .run();
  }

  std::optional<ContentBlobs> content(std::int64_t map) override {
    Statement statement(
        database_,
        "SELECT revision, features, descriptors, grid FROM map_contents WHERE map_id = ?");
    if (!statement.bind(map).step()) return std::nullopt;
    return ContentBlobs{.revision = statement.number(0),
                        .features = copy_of(statement.blob(1)),
                        .descriptors = copy_of(statement.blob(2)),
                        .grid = copy_of(statement.blob(3))};
  }

  void put_content(std::int64_t map, const ContentBlobs& content) override {
    Statement(database_,
              "INSERT OR REPLACE INTO map_contents (map_id, revision, features, descriptors, grid) "
              "VALUES (?, ?, ?, ?, ?)")
        .bind(map, content.revision, BlobView(content.features), BlobView(content.descriptors),
              BlobView(content.grid))
        .run();
  }

  std::vector<SketchState> sketch_states() override {
    Statement row(database_,
                  "SELECT id, name, maps.revision, min_x IS NOT NULL, map_sketches.revision "
                  "FROM maps LEFT JOIN map_sketches ON map_id = id ORDER BY id");
    std::vector<SketchState> states;
    while (row.step()) {
      states.push_back({.id = row.integer(0),
                        .name = row.text(1),
                        .revision = row.number(2),
                        .has_content = row.integer(3) != 0,
                        .sketch_revision = row.is_null(4) ? 0 : row.number(4)});
    }
    return states;
  }

  std::vector<SketchRow> sketches(std::int64_t after, std::size_t limit) override {
    Statement row(database_,
                  "SELECT map_id, revision, sketch FROM map_sketches WHERE map_id > ? "
                  "ORDER BY map_id LIMIT ?");
    std::vector<SketchRow> sketches;
    for (row.bind(after, limit); row.step();) {
      sketches.push_back(
          {.map = row.integer(0), .revision = row.number(1), .sketch = copy_of(row.blob(2))});
    }
    return sketches;
  }

  void put_sketch(const SketchRow& row) override {
    Statement(database_,
              "INSERT OR REPLACE INTO map_sketches (map_id, revision, sketch) VALUES (?, ?, ?)")
        .bind(row.map, row.revision, BlobView(row.sketch))
        .run();
  }

  void set_feature_count(std::int64_t map, std::size_t count) override {
    Statement(database_, "UPDATE maps SET feature_count = ? WHERE id = ?").bind(count, map).run();
  }

 private:
  SqliteDatabase& database_;
};

}  // namespace

std::unique_ptr<MapTables> make_map_tables(SqliteDatabase& database) {
  return std::make_unique<SqliteMapTables>(database);
}

}  // namespace cornerfix::storage

#include "storage/sqlite/sqlite_tables.hpp"
#include "storage/sqlite/statement.hpp"

namespace cornerfix::storage {
namespace {

constexpr std::string_view kSelectSession =
    "SELECT number, id, robot, created, lidar_json, options_json, expected_sequence, last_answer, "
    "state, last_used, last_batch FROM sessions WHERE id = ?";

constexpr std::string_view kSelectPage =
    "SELECT number, id, robot, created, lidar_json, options_json, expected_sequence, last_answer, "
    "state, last_used, last_batch FROM sessions WHERE number > ?1 AND (?2 = '' OR robot = ?2) "
    "ORDER BY number LIMIT ?3";

class SqliteSessionTables : public SessionTables {
 public:
  explicit SqliteSessionTables(SqliteDatabase& database) : database_(database) {}

  std::optional<SessionRow> find(std::string_view id) override {
    Statement row(database_, kSelectSession);
    if (!row.bind(id).step()) return std::nullopt;
    return read_row(row);
  }

  std::vector<SessionRow> list(const SessionPage& page) override {
    Statement row(database_, kSelectPage);
    std::vector<SessionRow> rows;
    for (row.bind(page.after, page.robot, page.limit); row.step();) rows.push_back(read_row(row));
    return rows;
  }

  std::vector<SessionHead> find_heads(std::span<const std::string_view> ids) override {
    Statement row(database_, "SELECT number, expected_sequence, state FROM sessions WHERE id = ?");
    std::vector<SessionHead> heads;
    for (const std::string_view id : ids) {
      if (!row.bind(id).step()) continue;
      const BlobView state = row.blob(2);
      heads.push_back({.id = std::string(id),
                       .number = row.integer(0),
                       .expected_sequence = row.number(1),
                       .state = Blob(state.begin(), state.end())});
    }
    return heads;
  }

  std::optional<std::int64_t> version(std::string_view) override { return std::nullopt; }

  std::int64_t insert(const SessionRecord& record, BlobView state) override {
    Statement(database_,
              "INSERT INTO sessions (number, id, robot, created, lidar_json, options_json, "
              "expected_sequence, last_answer, state) "
              "VALUES (nullif(?, 0), ?, ?, ?, ?, ?, 0, '', ?)")
        .bind(record.number, record.id, record.robot, record.created, record.lidar_json,
              record.options_json, state)
        .run();
    const std::int64_t session = database_.last_row_id();
    Statement map(database_,
                  "INSERT INTO session_maps (session, ordinal, map, map_id) VALUES (?, ?, ?, ?)");
    for (std::size_t i = 0; i < record.maps.size(); ++i) {
      map.bind(session, i, record.maps[i], record.map_ids[i]).run();
    }
    return session;
  }

  void write_answers(std::span<const AnswerRow> rows) override {
    Statement update(database_,
                     "UPDATE sessions SET expected_sequence = ?, last_answer = ?, state = ?, "
                     "last_used = ?, last_batch = ? WHERE number = ?");
    for (const AnswerRow& row : rows) {
      update
          .bind(row.expected_sequence, row.last_answer, row.state, row.last_used, row.last_batch,
                row.session)
          .run();
    }
  }

  bool remove(std::string_view id) override {
    return Statement(database_, "DELETE FROM sessions WHERE id = ?").bind(id).run() > 0;
  }

  std::size_t remove_unused_since(std::string_view time) override {
    Statement statement(database_, "DELETE FROM sessions WHERE last_used < ?");
    return static_cast<std::size_t>(statement.bind(time).run());
  }

  std::size_t count() override {
    Statement row(database_, "SELECT count(*) FROM sessions");
    row.step();
    return static_cast<std::size_t>(row.number(0));
  }

  std::optional<std::string> robot_of(std::string_view id) override {
    Statement row(database_, "SELECT robot FROM sessions WHERE id = ?");
    if (!row.bind(id).step()) return std::nullopt;
    return row.text(0);
  }

  std::size_t count(std::string_view robot) override {
    Statement row(database_, "SELECT count(*) FROM sessions WHERE robot = ?");
    row.bind(robot).step();
    return static_cast<std::size_t>(row.number(0));
  }

  std::string newest(std::string_view robot) override {
    Statement row(database_,
                  "SELECT id FROM sessions WHERE robot = ? ORDER BY number DESC LIMIT 1");
    return row.bind(robot).step() ? row.text(0) : std::string();
  }

  std::vector<ScanBlob> scans(std::int64_t session) override {
    Statement row(database_, "SELECT scan_index, scan FROM submap_scans WHERE session = ?");
    std::vector<ScanBlob> scans;
    for (row.bind(session); row.step();) {
      const BlobView scan = row.blob(1);
      scans.emplace_back(row.number(0), Blob(scan.begin(), scan.end()));
    }
    return scans;
  }

  void put_scans(std::span<const SubmapScanRow> scans) override {
    Statement upsert(database_,
                     "INSERT OR REPLACE INTO submap_scans (session, scan_index, scan) "
                     "VALUES (?, ?, ?)");
    for (const SubmapScanRow& row : scans)
      upsert.bind(row.session, row.index, BlobView(row.scan)).run();
  }

  void remove_scans(std::span<const SubmapScanRowKey> scans) override {
    Statement vanish(database_, "DELETE FROM submap_scans WHERE session = ? AND scan_index = ?");
    for (const SubmapScanRowKey& key : scans) vanish.bind(key.session, key.index).run();
  }

 private:
  SessionRow read_row(const Statement& row) {
    SessionRow session;
    SessionRecord& record = session.record;
    record.number = row.integer(0);
    record.id = row.text(1);
    record.robot = row.text(2);
    record.created = row.text(3);
    record.lidar_json = row.text(4);
    record.options_json = row.text(5);
    record.expected_sequence = row.number(6);
    record.last_answer = row.text(7);
    record.last_used = row.text(9);
    record.last_batch = row.number(10);
    const BlobView state = row.blob(8);
    session.state.assign(state.begin(), state.end());
    Statement map(database_,
                  "SELECT map, map_id FROM session_maps WHERE session = ? ORDER BY ordinal");
    for (map.bind(record.number); map.step();) {
      record.maps.push_back(map.text(0));
      record.map_ids.push_back(map.integer(1));
    }
    return session;
  }

  SqliteDatabase& database_;
};

}  // namespace

std::unique_ptr<SessionTables> make_session_tables(SqliteDatabase& database) {
  return std::make_unique<SqliteSessionTables>(database);
}

}  // namespace cornerfix::storage

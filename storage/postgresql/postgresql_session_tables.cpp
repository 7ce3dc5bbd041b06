#include <algorithm>
#include <limits>
#include <string>
#include <unordered_map>

#include "storage/postgresql/postgresql_connection.hpp"
#include "storage/postgresql/postgresql_tables.hpp"

namespace cornerfix::storage {
namespace {

const std::string kSelectSessions =
    "SELECT number, id, robot, created, lidar_json, options_json, expected_sequence, last_answer, "
    "state, last_used, last_batch FROM sessions ";

SessionRow read_session(const PostgresqlRows& rows, int row) {
  SessionRow session;
  SessionRecord& record = session.record;
  record.number = rows.integer(row, 0);
  record.id = rows.text(row, 1);
  record.robot = rows.text(row, 2);
  record.created = rows.text(row, 3);
  record.lidar_json = rows.text(row, 4);
  record.options_json = rows.text(row, 5);
  record.expected_sequence = rows.number(row, 6);
  record.last_answer = rows.text(row, 7);
  session.state = rows.copy(row, 8);
  record.last_used = rows.text(row, 9);
  record.last_batch = rows.number(row, 10);
  return session;
}

class PostgresqlSessionTables : public SessionTables {
 public:
  explicit PostgresqlSessionTables(PostgresqlConnection& connection) : connection_(connection) {}

  std::optional<SessionRow> find(std::string_view id) override {
    static const std::string sql = kSelectSessions + "WHERE id = $1";
    std::vector<SessionRow> found = with_maps(connection_.execute(sql.c_str(), id));
    if (found.empty()) return std::nullopt;
    return std::move(found.front());
  }

  std::vector<SessionRow> list(const SessionPage& page) override {
    static const std::string sql =
        kSelectSessions + "WHERE number > $1 AND ($2 = '' OR robot = $2) ORDER BY number LIMIT $3";
    constexpr std::size_t kMost = std::numeric_limits<std::int64_t>::max();
    return with_maps(
        connection_.execute(sql.c_str(), page.after, page.robot, std::min(page.limit, kMost)));
  }

  std::optional<SessionHead> find_head(std::string_view id) override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT number, expected_sequence, version, state FROM sessions WHERE id = $1 FOR UPDATE",
        id);
    if (rows.empty()) return std::nullopt;
    return SessionHead{.number = rows.integer(0, 0),
                       .expected_sequence = rows.number(0, 1),
                       .version = rows.integer(0, 2),
                       .state = rows.copy(0, 3)};
  }

  std::optional<std::int64_t> version(std::string_view id) override {
    const PostgresqlRows rows =
        connection_.execute("SELECT version FROM sessions WHERE id = $1", id);
    return rows.empty() ? 0 : rows.integer(0, 0);
  }

  std::int64_t insert(const SessionRecord& record, BlobView state) override {
    const PostgresqlRows rows = connection_.execute(
        "INSERT INTO sessions (number, id, robot, created, lidar_json, options_json, "
        "expected_sequence, last_answer, last_batch, last_used, version, state) "
        "VALUES (coalesce(nullif($1, 0), nextval('sessions_number_seq')), $2, $3, $4, $5, $6, "
        "0, '', 0, '', 0, $7) RETURNING number",
        record.number, record.id, record.robot, record.created, record.lidar_json,
        record.options_json, state);
    const std::int64_t session = rows.integer(0, 0);
    for (std::size_t i = 0; i < record.maps.size(); ++i) {
      (void)connection_.execute(
          "INSERT INTO session_maps (session, ordinal, map, map_id) VALUES ($1, $2, $3, $4)",
          session, i, record.maps[i], record.map_ids[i]);
    }
    return session;
  }

  void write_answer(std::int64_t session, const AnswerRow& row) override {
    (void)connection_.execute(
        "UPDATE sessions SET expected_sequence = $1, last_answer = $2, state = $3, "
        "last_used = $4, last_batch = $5, version = version + 1 WHERE number = $6",
        row.expected_sequence, row.last_answer, row.state, row.last_used, row.last_batch, session);
  }

  bool remove(std::string_view id) override {
    return connection_.execute("DELETE FROM sessions WHERE id = $1", id).changed() > 0;
  }

  std::size_t remove_unused_since(std::string_view time) override {
    return connection_.execute("DELETE FROM sessions WHERE last_used < $1", time).changed();
  }

  std::size_t count() override {
    return static_cast<std::size_t>(
        connection_.execute("SELECT count(*) FROM sessions").number(0, 0));
  }

  std::optional<std::string> robot_of(std::string_view id) override {
    const PostgresqlRows rows = connection_.execute("SELECT robot FROM sessions WHERE id = $1", id);
    if (rows.empty()) return std::nullopt;
    return rows.text(0, 0);
  }

  std::size_t count(std::string_view robot) override {
    const PostgresqlRows rows =
        connection_.execute("SELECT count(*) FROM sessions WHERE robot = $1", robot);
    return static_cast<std::size_t>(rows.number(0, 0));
  }

  std::string newest(std::string_view robot) override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT id FROM sessions WHERE robot = $1 ORDER BY number DESC LIMIT 1", robot);
    return rows.empty() ? std::string() : rows.text(0, 0);
  }

  std::vector<ScanBlob> scans(std::int64_t session) override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT scan_index, scan FROM submap_scans WHERE session = $1", session);
    std::vector<ScanBlob> scans;
    scans.reserve(static_cast<std::size_t>(rows.size()));
    for (int row = 0; row < rows.size(); ++row)
      scans.emplace_back(rows.number(row, 0), rows.copy(row, 1));
    return scans;
  }

  void put_scans(std::int64_t session, std::span<const ScanBlob> scans) override {
    if (scans.empty()) return;
    std::vector<std::uint64_t> indices;
    std::vector<BlobView> blobs;
    for (const auto& [index, scan] : scans) {
      indices.push_back(index);
      blobs.emplace_back(scan);
    }
    (void)connection_.execute(
        "INSERT INTO submap_scans (session, scan_index, scan) "
        "SELECT $1, given.scan_index, given.scan FROM unnest($2, $3) AS given (scan_index, scan) "
        "ON CONFLICT (session, scan_index) DO UPDATE SET scan = excluded.scan",
        session, std::span<const std::uint64_t>(indices), std::span<const BlobView>(blobs));
  }

  void remove_scans(std::int64_t session, std::span<const std::uint64_t> indices) override {
    if (indices.empty()) return;
    (void)connection_.execute(
        "DELETE FROM submap_scans WHERE session = $1 AND scan_index = ANY ($2)", session, indices);
  }

 private:
  /// The sessions with the maps that they were asked for.
  std::vector<SessionRow> with_maps(const PostgresqlRows& rows) {
    std::vector<SessionRow> sessions;
    std::vector<std::int64_t> numbers;
    std::unordered_map<std::int64_t, std::size_t> places;
    for (int row = 0; row < rows.size(); ++row) {
      sessions.push_back(read_session(rows, row));
      numbers.push_back(sessions.back().record.number);
      places.emplace(numbers.back(), sessions.size() - 1);
    }
    if (sessions.empty()) return sessions;
    const PostgresqlRows maps = connection_.execute(
        "SELECT session, map, map_id FROM session_maps WHERE session = ANY ($1) "
        "ORDER BY session, ordinal",
        std::span<const std::int64_t>(numbers));
    for (int row = 0; row < maps.size(); ++row) {
      SessionRecord& record = sessions[places.at(maps.integer(row, 0))].record;
      record.maps.push_back(maps.text(row, 1));
      record.map_ids.push_back(maps.integer(row, 2));
    }
    return sessions;
  }

  PostgresqlConnection& connection_;
};

}  // namespace

std::unique_ptr<SessionTables> make_session_tables(PostgresqlConnection& connection) {
  return std::make_unique<PostgresqlSessionTables>(connection);
}

}  // namespace cornerfix::storage

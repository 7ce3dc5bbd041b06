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

/// One member of each row, for a parameter that is an array.
template <typename Row, typename Value>
std::vector<Value> column(std::span<const Row> rows, Value Row::*member) {
  std::vector<Value> values;
  values.reserve(rows.size());
  for (const Row& row : rows) values.push_back(row.*member);
  return values;
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

  std::vector<SessionHead> find_heads(std::span<const std::string_view> ids) override {
    // Locked in one order, so that no two servers wait for each other.
    const PostgresqlRows rows = connection_.execute(
        "SELECT id, number, expected_sequence, version, state FROM sessions WHERE id = ANY ($1) "
        "ORDER BY number FOR UPDATE",
        ids);
    std::vector<SessionHead> heads;
    heads.reserve(static_cast<std::size_t>(rows.size()));
    for (int row = 0; row < rows.size(); ++row) {
      heads.push_back({.id = rows.text(row, 0),
                       .number = rows.integer(row, 1),
                       .expected_sequence = rows.number(row, 2),
                       .version = rows.integer(row, 3),
                       .state = rows.copy(row, 4)});
    }
    return heads;
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

  void write_answers(std::span<const AnswerRow> rows) override {
    (void)connection_.execute(
        "UPDATE sessions SET expected_sequence = given.expected_sequence, "
        "last_answer = given.last_answer, state = given.state, last_used = given.last_used, "
        "last_batch = given.last_batch, version = version + 1 "
        "FROM unnest($1, $2, $3, $4, $5, $6) AS given "
        "(number, expected_sequence, last_answer, state, last_used, last_batch) "
        "WHERE sessions.number = given.number",
        column(rows, &AnswerRow::session), column(rows, &AnswerRow::expected_sequence),
        column(rows, &AnswerRow::last_answer), column(rows, &AnswerRow::state),
        column(rows, &AnswerRow::last_used), column(rows, &AnswerRow::last_batch));
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

  void put_scans(std::span<const SubmapScanRow> scans) override {
    if (scans.empty()) return;
    std::vector<BlobView> blobs;
    for (const SubmapScanRow& row : scans) blobs.emplace_back(row.scan);
    (void)connection_.execute(
        "INSERT INTO submap_scans (session, scan_index, scan) "
        "SELECT given.session, given.scan_index, given.scan "
        "FROM unnest($1, $2, $3) AS given (session, scan_index, scan) "
        "ON CONFLICT (session, scan_index) DO UPDATE SET scan = excluded.scan",
        column(scans, &SubmapScanRow::session), column(scans, &SubmapScanRow::index), blobs);
  }

  void remove_scans(std::span<const SubmapScanRowKey> scans) override {
    if (scans.empty()) return;
    (void)connection_.execute(
        "DELETE FROM submap_scans USING unnest($1, $2) AS given (session, scan_index) "
        "WHERE submap_scans.session = given.session "
        "AND submap_scans.scan_index = given.scan_index",
        column(scans, &SubmapScanRowKey::session), column(scans, &SubmapScanRowKey::index));
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

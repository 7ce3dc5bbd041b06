#include "storage/session_store.hpp"

#include <SQLiteCpp/Database.h>

#include <cassert>
#include <optional>
#include <unordered_map>
#include <utility>

#include "storage/blob_codec.hpp"
#include "storage/database.hpp"
#include "storage/statement.hpp"

namespace cornerfix::storage {

/// A submap scan as it was last written, known by its stamp too: indices begin anew with a submap.
struct StoredScan {
  std::uint32_t checksum = 0;
  std::optional<double> stamp;  ///< Not known of one that was found in the file.
};
using StoredScans = std::unordered_map<std::uint64_t, StoredScan>;  ///< By index.

namespace {

constexpr std::string_view kSelectSession =
    "SELECT number, id, robot, created, lidar_json, options_json, expected_sequence, last_answer, "
    "state, last_used, last_batch FROM sessions WHERE id = ?";

constexpr std::string_view kSelectPage =
    "SELECT number, id, robot, created, lidar_json, options_json, expected_sequence, last_answer, "
    "state, last_used, last_batch FROM sessions WHERE number > ?1 AND (?2 = '' OR robot = "
    "?2) "
    "ORDER BY number LIMIT ?3";

Error unknown_session(std::string_view id) {
  return Error{ErrorCode::kNotFound, "there is no session '" + std::string(id) + "'", "session"};
}

StoredScans by_index(std::span<const SubmapScanKey> keys) {
  StoredScans scans;
  for (const SubmapScanKey& key : keys) scans.emplace(key.index, StoredScan{key.checksum, {}});
  return scans;
}

/// Makes the stored submap scans those of `submap`, writing only what differs. `stored` is what is
/// there before and after; returns the names of the scans in their order.
std::vector<SubmapScanKey> sync_submap(Database& database, std::int64_t session,
                                       std::span<const SubmapScan> submap, StoredScans& stored) {
  Statement upsert(database,
                   "INSERT OR REPLACE INTO submap_scans (session, scan_index, scan) "
                   "VALUES (?, ?, ?)");
  std::vector<SubmapScanKey> keys;
  keys.reserve(submap.size());
  StoredScans kept;
  for (const SubmapScan& scan : submap) {
    const auto found = stored.find(scan.index);
    const bool is_known = found != stored.end() && found->second.stamp == scan.scan.stamp;
    if (is_known) {
      keys.push_back({scan.index, found->second.checksum});
    } else {
      const Blob blob = encode_submap_scan(scan);
      keys.push_back({scan.index, checksum_of(blob)});
      const bool is_stored =
          found != stored.end() && found->second.checksum == keys.back().checksum;
      if (!is_stored) upsert.bind(session, scan.index, BlobView(blob)).run();
    }
    kept.emplace(scan.index, StoredScan{keys.back().checksum, scan.scan.stamp});
    if (found != stored.end()) stored.erase(found);
  }
  Statement vanish(database, "DELETE FROM submap_scans WHERE session = ? AND scan_index = ?");
  for (const auto& [index, scan] : stored) vanish.bind(session, index).run();
  stored = std::move(kept);
  return keys;
}

struct AnswerRow {
  std::uint64_t expected_sequence = 0;
  std::string_view last_answer;
  BlobView state;
  std::string_view last_used;
  std::uint64_t last_batch = 0;
};

void write_answer(Database& database, std::int64_t session, const AnswerRow& row) {
  Statement(database,
            "UPDATE sessions SET expected_sequence = ?, last_answer = ?, state = ?, "
            "last_used = ?, last_batch = ? WHERE number = ?")
      .bind(row.expected_sequence, row.last_answer, row.state, row.last_used, row.last_batch,
            session)
      .run();
}

void read_maps(Database& database, std::int64_t session, SessionRecord& record) {
  Statement statement(database,
                      "SELECT map, map_id FROM session_maps WHERE session = ? ORDER BY ordinal");
  for (statement.bind(session); statement.step();) {
    record.maps.push_back(statement.text(0));
    record.map_ids.push_back(statement.integer(1));
  }
}

/// The session's submap scans in the order of `keys`.
Result<std::vector<SubmapScan>> read_submap(Database& database, std::int64_t session,
                                            std::span<const SubmapScanKey> keys) {
  Statement statement(database,
                      "SELECT scan FROM submap_scans WHERE session = ? AND scan_index = ?");
  std::vector<SubmapScan> submap;
  submap.reserve(keys.size());
  for (const SubmapScanKey& key : keys) {
    const bool found = statement.bind(session, key.index).step();
    Result<SubmapScan> scan = decode_submap_scan(found ? statement.blob(0) : BlobView());
    if (!scan) return scan.error();
    if (checksum_of(statement.blob(0)) != key.checksum || scan->index != key.index) {
      return Error{ErrorCode::kCorruptData, "the session's state names another scan", ""};
    }
    submap.push_back(std::move(*scan));
  }
  return submap;
}

Result<LocalizerState> read_state(Database& database, std::int64_t session, BlobView state) {
  Result<LocalizerStateOutline> outline = decode_localizer_state(state);
  if (!outline) return outline.error();
  Result<std::vector<SubmapScan>> submap = read_submap(database, session, outline->submap);
  if (!submap) return submap.error();
  outline->state.submap = std::move(*submap);
  return std::move(outline->state);
}

/// All but the state.
SessionRecord read_record(Database& database, const Statement& row) {
  SessionRecord record;
  record.number = row.integer(0);
  record.id = row.text(1);
  record.robot = row.text(2);
  record.created = row.text(3);
  read_maps(database, record.number, record);
  record.lidar_json = row.text(4);
  record.options_json = row.text(5);
  record.expected_sequence = row.number(6);
  record.last_answer = row.text(7);
  record.last_used = row.text(9);
  record.last_batch = row.number(10);
  return record;
}

Error in_session(const SessionRecord& record, const Error& error) {
  return {error.code, "session " + record.id + ": " + error.message, "session"};
}

Result<std::optional<SessionRecord>> read_session(Database& database, std::string_view id) {
  Statement row(database, kSelectSession);
  if (!row.bind(id).step()) return std::optional<SessionRecord>();
  SessionRecord record = read_record(database, row);
  Result<LocalizerState> state = read_state(database, record.number, row.blob(8));
  if (!state) return in_session(record, state.error());
  record.state = std::move(*state);
  return std::optional(std::move(record));
}

}  // namespace

/// What update() must know of a stored session.
struct SessionStore::StoredSession {
  std::int64_t number = 0;
  std::uint64_t expected_sequence = 0;
  StoredScans submap;
};

namespace {

/// Sessions whose stored state is remembered, to bound the memory: 2 kB each.
constexpr std::size_t kMaxKnownSessions = 10'000;

}  // namespace

/// As the file has it, or as this connection wrote it when nobody else has changed the file since.
/// In a write transaction.
Result<SessionStore::StoredSession*> SessionStore::find_for_update(std::string_view id) {
  const auto version = database_->data_version();
  if (!version) return version.error();
  if (*version != known_version_ || known_.size() > kMaxKnownSessions) known_.clear();
  known_version_ = *version;
  const auto known = known_.find(std::string(id));
  if (known != known_.end()) return &known->second;
  Statement row(*database_, "SELECT number, expected_sequence, state FROM sessions WHERE id = ?");
  if (!row.bind(id).step()) return unknown_session(id);
  const Result<LocalizerStateOutline> outline = decode_localizer_state(row.blob(2));
  if (!outline) return outline.error();
  StoredSession stored{row.integer(0), row.number(1), by_index(outline->submap)};
  return &known_.emplace(id, std::move(stored)).first->second;
}

SessionStore::SessionStore(std::shared_ptr<Database> database) : database_(std::move(database)) {}
SessionStore::~SessionStore() = default;
SessionStore::SessionStore(SessionStore&&) noexcept = default;

Result<void> SessionStore::insert(const SessionRecord& record) {
  assert(record.map_ids.size() == record.maps.size() && "an id a map");
  return guarded([&]() -> Result<void> {
    WriteTransaction transaction(*database_);
    const Blob no_state = encode_localizer_state({}, {});
    Statement(*database_,
              "INSERT INTO sessions (id, robot, created, lidar_json, options_json, "
              "expected_sequence, last_answer, state) VALUES (?, ?, ?, ?, ?, 0, '', ?)")
        .bind(record.id, record.robot, record.created, record.lidar_json, record.options_json,
              BlobView(no_state))
        .run();
    const std::int64_t session = database_->connection().getLastInsertRowid();
    Statement map(*database_,
                  "INSERT INTO session_maps (session, ordinal, map, map_id) VALUES (?, ?, ?, ?)");
    for (std::size_t i = 0; i < record.maps.size(); ++i) {
      map.bind(session, i, record.maps[i], record.map_ids[i]).run();
    }
    StoredScans nothing;
    const std::vector<SubmapScanKey> submap =
        sync_submap(*database_, session, record.state.submap, nothing);
    const Blob state = encode_localizer_state(record.state, submap);
    write_answer(*database_, session,
                 {.expected_sequence = record.expected_sequence,
                  .last_answer = record.last_answer,
                  .state = state,
                  .last_used = record.last_used.empty() ? record.created : record.last_used,
                  .last_batch = record.last_batch});
    transaction.commit();
    return {};
  });
}

Result<void> SessionStore::update(std::string_view id, const SessionUpdate& update) {
  Result<void> updated = guarded([&] { return update_in_transaction(id, update); });
  if (!updated) known_.erase(std::string(id));  // It may be ahead of the file.
  return updated;
}

Result<void> SessionStore::update_in_transaction(std::string_view id, const SessionUpdate& update) {
  WriteTransaction transaction(*database_);
  const Result<StoredSession*> found = find_for_update(id);
  if (!found) return found.error();
  StoredSession& stored = **found;
  if (stored.expected_sequence != update.previous_sequence) {
    return Error{ErrorCode::kConflict,
                 "the session expects sequence " + std::to_string(stored.expected_sequence) +
                     ", not " + std::to_string(update.previous_sequence),
                 "sequence"};
  }
  const std::vector<SubmapScanKey> submap =
      sync_submap(*database_, stored.number, update.state->submap, stored.submap);
  const Blob state = encode_localizer_state(*update.state, submap);
  write_answer(*database_, stored.number,
               {.expected_sequence = update.expected_sequence,
                .last_answer = update.last_answer,
                .state = state,
                .last_used = update.now,
                .last_batch = update.last_batch});
  transaction.commit();
  stored.expected_sequence = update.expected_sequence;
  return {};
}

Result<void> SessionStore::remove(std::string_view id) {
  known_.erase(std::string(id));
  return guarded([&]() -> Result<void> {
    WriteTransaction transaction(*database_);
    const int removed = Statement(*database_, "DELETE FROM sessions WHERE id = ?").bind(id).run();
    transaction.commit();
    if (removed == 0) return unknown_session(id);
    return {};
  });
}

Result<std::optional<SessionRecord>> SessionStore::find(std::string_view id) {
  return guarded([&]() -> Result<std::optional<SessionRecord>> {
    ReadTransaction transaction(*database_);
    return read_session(*database_, id);
  });
}

Result<std::vector<SessionRecord>> SessionStore::list(const SessionPage& page) {
  return guarded([&]() -> Result<std::vector<SessionRecord>> {
    ReadTransaction transaction(*database_);
    Statement row(*database_, kSelectPage);
    std::vector<SessionRecord> records;
    for (row.bind(page.after, page.robot, page.limit); row.step();) {
      SessionRecord record = read_record(*database_, row);
      Result<LocalizerStateOutline> outline = decode_localizer_state(row.blob(8));
      record.is_damaged = !outline;
      if (outline) record.state = std::move(outline->state);
      records.push_back(std::move(record));
    }
    return records;
  });
}

Result<std::size_t> SessionStore::count(std::string_view robot) {
  return guarded([&]() -> Result<std::size_t> {
    Statement row(*database_, "SELECT count(*) FROM sessions WHERE robot = ?");
    row.bind(robot).step();
    return static_cast<std::size_t>(row.number(0));
  });
}

Result<std::size_t> SessionStore::count_all() {
  return guarded([&]() -> Result<std::size_t> {
    Statement row(*database_, "SELECT count(*) FROM sessions");
    row.step();
    return static_cast<std::size_t>(row.number(0));
  });
}

Result<std::string> SessionStore::robot_of(std::string_view id) {
  return guarded([&]() -> Result<std::string> {
    Statement row(*database_, "SELECT robot FROM sessions WHERE id = ?");
    if (!row.bind(id).step()) return unknown_session(id);
    return row.text(0);
  });
}

Result<std::string> SessionStore::newest(std::string_view robot) {
  return guarded([&]() -> Result<std::string> {
    Statement row(*database_,
                  "SELECT id FROM sessions WHERE robot = ? ORDER BY number DESC LIMIT 1");
    return row.bind(robot).step() ? row.text(0) : std::string();
  });
}

Result<std::size_t> SessionStore::remove_unused_since(std::string_view time) {
  known_.clear();
  return guarded([&]() -> Result<std::size_t> {
    WriteTransaction transaction(*database_);
    const int removed =
        Statement(*database_, "DELETE FROM sessions WHERE last_used < ?").bind(time).run();
    transaction.commit();
    return static_cast<std::size_t>(removed);
  });
}

}  // namespace cornerfix::storage

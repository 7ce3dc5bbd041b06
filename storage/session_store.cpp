#include "storage/session_store.hpp"

#include <algorithm>
#include <cassert>
#include <optional>
#include <unordered_map>
#include <utility>

#include "storage/blob_codec.hpp"
#include "storage/database.hpp"
#include "storage/session_tables.hpp"

namespace cornerfix::storage {

/// A submap scan as it was last written, known by its stamp too: indices begin anew with a submap.
struct StoredScan {
  std::uint64_t index = 0;
  std::uint32_t checksum = 0;
  std::optional<double> stamp;  ///< Not known of one that was found in the file.
};
using StoredScans = std::vector<StoredScan>;  ///< By rising index.

/// Submap scans that differ from what is stored.
struct SubmapChanges {
  std::vector<SubmapScanRow> changed;
  std::vector<SubmapScanRowKey> vanished;

  void write(SessionTables& sessions) const {
    sessions.remove_scans(vanished);  // First, so that its pages can be used again at once.
    sessions.put_scans(changed);
  }
};

namespace {

Error unknown_session(std::string_view id) {
  return Error{ErrorCode::kNotFound, "there is no session '" + std::string(id) + "'", "session"};
}

/// Null when there is none.
const StoredScan* find_scan(const StoredScans& scans, std::uint64_t index) {
  const auto found = std::ranges::lower_bound(scans, index, {}, &StoredScan::index);
  return found != scans.end() && found->index == index ? &*found : nullptr;
}

/// Adds to `changes` what makes the stored submap scans those of `submap`. `stored` is what is
/// there before and after; returns the names of the scans in their order.
std::vector<SubmapScanKey> sync_submap(std::int64_t session, std::span<const SubmapScanPtr> submap,
                                       StoredScans& stored, SubmapChanges& changes) {
  std::vector<SubmapScanKey> keys;
  keys.reserve(submap.size());
  StoredScans kept;
  kept.reserve(submap.size());
  for (const SubmapScanPtr& scan : submap) {
    const StoredScan* found = find_scan(stored, scan->index);
    if (found != nullptr && found->stamp == scan->scan.stamp) {
      keys.push_back({scan->index, found->checksum});
    } else {
      Blob blob = encode_submap_scan(*scan);
      keys.push_back({scan->index, checksum_of(blob)});
      const bool is_stored = found != nullptr && found->checksum == keys.back().checksum;
      if (!is_stored) changes.changed.push_back({session, scan->index, std::move(blob)});
    }
    kept.push_back({scan->index, keys.back().checksum, scan->scan.stamp});
  }
  std::ranges::sort(kept, {}, &StoredScan::index);
  for (const StoredScan& scan : stored) {
    if (find_scan(kept, scan.index) == nullptr) changes.vanished.push_back({session, scan.index});
  }
  stored = std::move(kept);
  return keys;
}

/// The session's submap scans in the order of `keys`.
Result<std::vector<SubmapScanPtr>> read_submap(SessionTables& sessions, std::int64_t session,
                                               std::span<const SubmapScanKey> keys) {
  std::unordered_map<std::uint64_t, Blob> stored;
  for (auto& [index, blob] : sessions.scans(session)) stored.emplace(index, std::move(blob));
  std::vector<SubmapScanPtr> submap;
  submap.reserve(keys.size());
  for (const SubmapScanKey& key : keys) {
    const Blob& blob = stored[key.index];  // Empty when it is missing: refused as cut short.
    Result<SubmapScan> scan = decode_submap_scan(blob);
    if (!scan) return scan.error();
    if (checksum_of(blob) != key.checksum || scan->index != key.index) {
      return Error{ErrorCode::kCorruptData, "the session's state names another scan", ""};
    }
    submap.push_back(std::make_shared<const SubmapScan>(std::move(*scan)));
  }
  return submap;
}

Result<LocalizerState> read_state(SessionTables& sessions, std::int64_t session, BlobView state) {
  Result<LocalizerStateOutline> outline = decode_localizer_state(state);
  if (!outline) return outline.error();
  Result<std::vector<SubmapScanPtr>> submap = read_submap(sessions, session, outline->submap);
  if (!submap) return submap.error();
  outline->state.submap = std::move(*submap);
  return std::move(outline->state);
}

Error in_session(const SessionRecord& record, const Error& error) {
  return {error.code, "session " + record.id + ": " + error.message, "session"};
}

/// Sessions whose stored state is remembered, to bound the memory: 4 kB each.
constexpr std::size_t kMaxKnownSessions = 10'000;

}  // namespace

/// What this store knows of a stored session.
struct SessionStore::StoredSession {
  std::int64_t number = 0;
  std::uint64_t expected_sequence = 0;
  Blob state{};
  std::uint64_t scans = 0;  ///< Of its state.
  StoredScans submap{};
  std::int64_t version = 0;           ///< As SessionTables::version() when it was last seen.
  std::uint64_t foreign_changes = 0;  ///< Raised whenever another one was seen.
};

/// What a transaction writes, and what this store then knows.
struct SessionStore::RowsToWrite {
  SubmapChanges submaps{};
  std::vector<AnswerRow> answers{};
  std::vector<StoredSession*> written{};
};

SessionStore::StoredSession& SessionStore::known(std::string_view id) {
  if (known_.size() >= kMaxKnownSessions && !known_.contains(std::string(id))) known_.clear();
  return known_[std::string(id)];
}

/// As the database has it, with the stamps of the scans that this store wrote itself.
Result<SessionStore::StoredSession*> SessionStore::note_head(const SessionHead& head) {
  StoredSession& stored = known(head.id);
  note_version(stored, head.version);
  stored.expected_sequence = head.expected_sequence;
  if (stored.number == head.number && stored.state == head.state) return &stored;
  const Result<LocalizerStateOutline> outline = decode_localizer_state(head.state);
  if (!outline) return outline.error();
  StoredScans submap;
  submap.reserve(outline->submap.size());
  for (const SubmapScanKey& key : outline->submap) {
    const StoredScan* found = find_scan(stored.submap, key.index);
    const bool is_ours = found != nullptr && found->checksum == key.checksum;
    submap.push_back(is_ours ? *found : StoredScan{key.index, key.checksum, {}});
  }
  std::ranges::sort(submap, {}, &StoredScan::index);
  stored.number = head.number;
  stored.scans = outline->state.scans;
  stored.state = head.state;
  stored.submap = std::move(submap);
  return &stored;
}

void SessionStore::note_version(StoredSession& stored, std::int64_t version) {
  if (stored.version == version && stored.foreign_changes > 0) return;
  stored.version = version;
  stored.foreign_changes = ++foreign_changes_;
}

Result<std::uint64_t> SessionStore::foreign_changes(std::string_view id) {
  return guarded([&]() -> Result<std::uint64_t> {
    const std::optional<std::int64_t> version = database_->sessions().version(id);
    if (!version) return std::uint64_t{0};
    StoredSession& stored = known(id);
    note_version(stored, *version);
    return stored.foreign_changes;
  });
}

SessionStore::SessionStore(std::shared_ptr<Database> database) : database_(std::move(database)) {}
SessionStore::~SessionStore() = default;
SessionStore::SessionStore(SessionStore&&) noexcept = default;

Result<void> SessionStore::insert(const SessionRecord& record) {
  assert(record.map_ids.size() == record.maps.size() && "an id a map");
  return guarded([&]() -> Result<void> {
    const auto transaction = database_->begin(Access::kWrite);
    SessionTables& sessions = database_->sessions();
    const std::int64_t session = sessions.insert(record, encode_localizer_state({}, {}));
    StoredScans nothing;
    SubmapChanges changes;
    const std::vector<SubmapScanKey> submap =
        sync_submap(session, record.state.submap, nothing, changes);
    const Blob state = encode_localizer_state(record.state, submap);
    const AnswerRow row{.session = session,
                        .expected_sequence = record.expected_sequence,
                        .last_answer = record.last_answer,
                        .state = state,
                        .last_used = record.last_used.empty() ? record.created : record.last_used,
                        .last_batch = record.last_batch};
    changes.write(sessions);
    sessions.write_answers(std::span(&row, 1));
    transaction->commit();
    return {};
  });
}

Result<void> SessionStore::update(std::string_view id, const SessionUpdate& update) {
  const SessionChange change{id, update};
  return this->update(std::span(&change, 1)).front();
}

std::vector<Result<void>> SessionStore::update(std::span<const SessionChange> changes) {
  if (changes.empty()) return {};
  // Before pointers into it are held.
  if (known_.size() + changes.size() > kMaxKnownSessions) known_.clear();
  std::vector<Result<void>> results(changes.size());
  const Result<void> done = guarded([&]() -> Result<void> {
    update_in_transaction(changes, results);
    return {};
  });
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (!done && results[i]) results[i] = done.error();
    // It may be ahead of the file.
    if (!results[i]) known_.erase(std::string(changes[i].id));
  }
  return results;
}

void SessionStore::update_in_transaction(std::span<const SessionChange> changes,
                                         std::span<Result<void>> results) {
  const auto transaction = database_->begin(Access::kWrite);
  SessionTables& sessions = database_->sessions();
  std::vector<std::string_view> ids;
  for (const SessionChange& change : changes) ids.push_back(change.id);
  const std::vector<SessionHead> heads = sessions.find_heads(ids);
  std::unordered_map<std::string_view, const SessionHead*> head_of;
  for (const SessionHead& head : heads) head_of.emplace(head.id, &head);
  RowsToWrite rows;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const auto head = head_of.find(changes[i].id);
    results[i] = add_rows(changes[i], head == head_of.end() ? nullptr : head->second, rows);
  }
  if (rows.answers.empty()) return;
  rows.submaps.write(sessions);
  sessions.write_answers(rows.answers);
  transaction->commit();
  for (StoredSession* stored : rows.written) ++stored->version;
}

Result<void> SessionStore::add_rows(const SessionChange& change, const SessionHead* head,
                                    RowsToWrite& rows) {
  if (head == nullptr) return unknown_session(change.id);
  const Result<StoredSession*> found = note_head(*head);
  if (!found) return found.error();
  StoredSession& stored = **found;
  const SessionUpdate& update = change.update;
  if (stored.expected_sequence != update.previous_sequence) {
    return Error{ErrorCode::kConflict,
                 "the session expects sequence " + std::to_string(stored.expected_sequence) +
                     ", not " + std::to_string(update.previous_sequence),
                 "sequence"};
  }
  if (update.previous_scans && *update.previous_scans != stored.scans)
    return Error{ErrorCode::kConflict, "the session was changed by another server", "sequence"};
  const std::vector<SubmapScanKey> submap =
      sync_submap(stored.number, update.state->submap, stored.submap, rows.submaps);
  stored.state = encode_localizer_state(*update.state, submap);
  stored.scans = update.state->scans;
  rows.answers.push_back({.session = stored.number,
                          .expected_sequence = update.expected_sequence,
                          .last_answer = update.last_answer,
                          .state = stored.state,
                          .last_used = update.now,
                          .last_batch = update.last_batch});
  rows.written.push_back(&stored);
  stored.expected_sequence = update.expected_sequence;
  return {};
}

Result<void> SessionStore::remove(std::string_view id) {
  known_.erase(std::string(id));
  return guarded([&]() -> Result<void> {
    const auto transaction = database_->begin(Access::kWrite);
    const bool was_there = database_->sessions().remove(id);
    transaction->commit();
    if (!was_there) return unknown_session(id);
    return {};
  });
}

Result<std::optional<SessionRecord>> SessionStore::find(std::string_view id) {
  return guarded([&]() -> Result<std::optional<SessionRecord>> {
    const auto transaction = database_->begin(Access::kRead);
    std::optional<SessionRow> row = database_->sessions().find(id);
    if (!row) return std::optional<SessionRecord>();
    SessionRecord& record = row->record;
    Result<LocalizerState> state = read_state(database_->sessions(), record.number, row->state);
    if (!state) return in_session(record, state.error());
    record.state = std::move(*state);
    return std::optional(std::move(record));
  });
}

Result<std::vector<SessionRecord>> SessionStore::list(const SessionPage& page) {
  return guarded([&]() -> Result<std::vector<SessionRecord>> {
    const auto transaction = database_->begin(Access::kRead);
    std::vector<SessionRecord> records;
    for (SessionRow& row : database_->sessions().list(page)) {
      Result<LocalizerStateOutline> outline = decode_localizer_state(row.state);
      row.record.is_damaged = !outline;
      if (outline) row.record.state = std::move(outline->state);
      records.push_back(std::move(row.record));
    }
    return records;
  });
}

Result<std::size_t> SessionStore::count(std::string_view robot) {
  return guarded([&]() -> Result<std::size_t> { return database_->sessions().count(robot); });
}

Result<std::size_t> SessionStore::count_all() {
  return guarded([&]() -> Result<std::size_t> { return database_->sessions().count(); });
}

Result<std::string> SessionStore::robot_of(std::string_view id) {
  return guarded([&]() -> Result<std::string> {
    std::optional<std::string> robot = database_->sessions().robot_of(id);
    if (!robot) return unknown_session(id);
    return std::move(*robot);
  });
}

Result<std::string> SessionStore::newest(std::string_view robot) {
  return guarded([&]() -> Result<std::string> { return database_->sessions().newest(robot); });
}

Result<std::size_t> SessionStore::remove_unused_since(std::string_view time) {
  known_.clear();
  return guarded([&]() -> Result<std::size_t> {
    const auto transaction = database_->begin(Access::kWrite);
    const std::size_t removed = database_->sessions().remove_unused_since(time);
    transaction->commit();
    return removed;
  });
}

}  // namespace cornerfix::storage

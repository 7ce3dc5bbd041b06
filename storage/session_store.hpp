/// \file  Robot sessions in a database, so that they survive a restart: expected sequence, last
/// answer, localizer state.
///
/// Each call is one transaction; not synchronised (one thread at a time). Synchronous::kNormal is
/// enough and is what the session connection uses: a killed process loses nothing. A power cut may
/// lose the last batches, which robots see as `expected` and post again.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <cornerfix/localizer.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix::storage {

class Database;
struct SessionHead;

struct SessionRecord {
  std::string id;
  std::string robot;
  std::string created;            ///< RFC 3339, UTC.
  std::vector<std::string> maps;  ///< As asked for, in order; empty: every map.
  std::string lidar_json;         ///< Opaque here.
  std::string options_json;       ///< Opaque here.
  std::uint64_t expected_sequence = 0;
  std::string
      last_answer;  ///< Body of the answer to expected_sequence - 1; empty before the first.
  LocalizerState state;
  /// Of the maps when they were asked for, in their order; 0 where not known.
  std::vector<std::int64_t> map_ids{};
  std::string last_used{};       ///< When it took its last batch, or was made: as `created`.
  std::uint64_t last_batch = 0;  ///< Digest of the batch that `last_answer` answers; 0: not known.
  /// Given by insert() where it is 0; grows from session to session.
  std::int64_t number = 0;
  bool is_damaged = false;  ///< Its stored state cannot be read; only list() gives such ones.
};

/// Which sessions to list.
struct SessionPage {
  std::string_view robot{};  ///< Its sessions only; empty: those of all robots.
  std::int64_t after = 0;    ///< Those with a larger `number`.
  std::size_t limit = 1000;
};

/// What one batch (or a reset) changes.
struct SessionUpdate {
  std::uint64_t previous_sequence =
      0;  ///< Must be what is stored, else kConflict: another process was first.
  std::uint64_t expected_sequence = 0;
  std::string_view last_answer;
  const LocalizerState* state = nullptr;  ///< Only submap scans that are not stored yet are
                                          ///< written; those no longer there go.
  std::string_view now{};                 ///< As `created`.
  std::uint64_t last_batch = 0;           ///< Digest of the batch; 0: not known.
  /// `scans` of the stored state, else kConflict; nothing: not compared. A reset keeps the sequence
  /// and zeroes this.
  std::optional<std::uint64_t> previous_scans{};
};

/// What changes of one session.
struct SessionChange {
  std::string_view id;
  SessionUpdate update;
};

class SessionStore {
 public:
  explicit SessionStore(std::shared_ptr<Database> database);
  ~SessionStore();
  SessionStore(SessionStore&&) noexcept;

  [[nodiscard]] Result<void> insert(const SessionRecord& record);
  [[nodiscard]] Result<void> update(std::string_view id,
                                    const SessionUpdate& update);  ///< kNotFound.
  /// Several sessions in one transaction, each named once: the results in their order. One that
  /// cannot be changed does not keep the others from it; a transaction that fails fails for all.
  [[nodiscard]] std::vector<Result<void>> update(std::span<const SessionChange> changes);
  [[nodiscard]] Result<void> remove(std::string_view id);  ///< kNotFound.
  [[nodiscard]] Result<std::optional<SessionRecord>> find(std::string_view id);
  /// By creation. Their states have no submaps.
  [[nodiscard]] Result<std::vector<SessionRecord>> list(const SessionPage& page);
  [[nodiscard]] Result<std::size_t> count(std::string_view robot);
  [[nodiscard]] Result<std::size_t> count_all();
  /// The robot of a session, also when its state is damaged. kNotFound.
  [[nodiscard]] Result<std::string> robot_of(std::string_view id);
  /// Id of the robot's session that was made last; empty when there is none.
  [[nodiscard]] Result<std::string> newest(std::string_view robot);
  /// Removes those last used before `time`; returns how many.
  [[nodiscard]] Result<std::size_t> remove_unused_since(std::string_view time);
  /// A number that changes when a writer other than this store has changed the session. Constant
  /// where Database::data_version() counts sessions too.
  [[nodiscard]] Result<std::uint64_t> foreign_changes(std::string_view id);

 private:
  struct StoredSession;
  struct RowsToWrite;

  void update_in_transaction(std::span<const SessionChange> changes,
                             std::span<Result<void>> results);
  /// Adds to `rows` what differs from the database.
  [[nodiscard]] Result<void> add_rows(const SessionChange& change, const SessionHead* head,
                                      RowsToWrite& rows);
  [[nodiscard]] Result<StoredSession*> note_head(const SessionHead& head);
  [[nodiscard]] StoredSession& known(std::string_view id);
  void note_version(StoredSession& stored, std::int64_t version);

  std::shared_ptr<Database> database_;
  /// What this store wrote last, so that a batch encodes only the scans that are new.
  std::unordered_map<std::string, StoredSession> known_;
  std::uint64_t foreign_changes_ = 0;
};

}  // namespace cornerfix::storage

/// \file  The rows of sessions, as an engine stores them. For SessionStore, which has the rules.
///
/// Functions throw; SessionStore calls them under guarded().
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "storage/blob_codec.hpp"
#include "storage/session_store.hpp"

namespace cornerfix::storage {

/// A session's row with its maps.
struct SessionRow {
  SessionRecord record;  ///< All but the state.
  Blob state;
};

/// What a batch needs of a session's row.
struct SessionHead {
  std::string id;
  std::int64_t number = 0;
  std::uint64_t expected_sequence = 0;
  std::int64_t version = 0;  ///< As SessionTables::version().
  Blob state;
};

struct AnswerRow {
  std::int64_t session = 0;
  std::uint64_t expected_sequence = 0;
  std::string_view last_answer;
  BlobView state;
  std::string_view last_used;
  std::uint64_t last_batch = 0;
};

struct SubmapScanRow {
  std::int64_t session = 0;
  std::uint64_t index = 0;
  Blob scan;
};

struct SubmapScanRowKey {
  std::int64_t session = 0;
  std::uint64_t index = 0;
};

class SessionTables {
 public:
  SessionTables() = default;
  virtual ~SessionTables() = default;
  SessionTables(const SessionTables&) = delete;
  SessionTables& operator=(const SessionTables&) = delete;

  virtual std::optional<SessionRow> find(std::string_view id) = 0;
  virtual std::vector<SessionRow> list(const SessionPage& page) = 0;
  /// Of those that are there, in any order. In a transaction that writes: other writers of these
  /// sessions wait for its end.
  virtual std::vector<SessionHead> find_heads(std::span<const std::string_view> ids) = 0;
  /// A number that every write of the session raises; 0 when there is no such session. Nothing
  /// where Database::data_version() counts sessions.
  virtual std::optional<std::int64_t> version(std::string_view id) = 0;

  /// Returns the new number; a record that has one keeps it.
  virtual std::int64_t insert(const SessionRecord& record, BlobView state) = 0;
  virtual void write_answers(std::span<const AnswerRow> rows) = 0;
  virtual bool remove(std::string_view id) = 0;
  virtual std::size_t remove_unused_since(std::string_view time) = 0;
  virtual std::size_t count() = 0;
  virtual std::size_t count(std::string_view robot) = 0;
  virtual std::optional<std::string> robot_of(std::string_view id) = 0;
  virtual std::string newest(std::string_view robot) = 0;

  using ScanBlob = std::pair<std::uint64_t, Blob>;  ///< Its index, and the scan.
  virtual std::vector<ScanBlob> scans(std::int64_t session) = 0;
  /// In place of those that have the same index.
  virtual void put_scans(std::span<const SubmapScanRow> scans) = 0;
  virtual void remove_scans(std::span<const SubmapScanRowKey> scans) = 0;
};

}  // namespace cornerfix::storage

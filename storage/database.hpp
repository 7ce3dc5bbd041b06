/// \file  A connection to a Cornerfix database of either engine: an SQLite file or PostgreSQL.
///
/// The stores (map_store.hpp, session_store.hpp, token_store.hpp, job_store.hpp) hold the rules
/// that both engines share. Each engine implements this interface and the tables that a store works
/// on.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <cornerfix/result.hpp>

namespace cornerfix::storage {

class JobTables;
class MapTables;
class SessionTables;
class TokenTables;

/// What survives a crash of the machine (SQLite) or of the database server (PostgreSQL). A killed
/// process of our own loses nothing in either.
enum class Synchronous {
  kFull,    ///< Every acknowledged commit: for maps. About 4 ms a commit.
  kNormal,  ///< All but the last commits, never half of one: for sessions.
};

/// How long a connection waits for another one's write before it gives up with kUnavailable.
inline constexpr int kDefaultBusyTimeoutMs = 5000;

enum class Access {
  kRead,   ///< One snapshot for several statements.
  kWrite,  ///< Rows that are found may be changed: another writer of them waits.
};

/// Rolled back unless committed. Throws; call it under guarded().
class Transaction {
 public:
  Transaction() = default;
  virtual ~Transaction() = default;
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  virtual void commit() = 0;
};

/// The last identifiers that were given to a row of each kind. None is given a second time.
struct LastIds {
  std::int64_t map = 0;
  std::int64_t session = 0;
  std::int64_t token = 0;
};

/// Not synchronised: one thread at a time. Any number of connections, of any process, may share a
/// database.
class Database {
 public:
  /// Opens `location`: `postgresql://…` or `postgres://…` (a URL of libpq), or else a file of
  /// SQLite, which is made when it does not exist or is empty. Migrates older schemas.
  ///
  /// Refuses a newer schema or a database of another program (kInvalidArgument), and a damaged file
  /// (kCorruptData); a refused database is unchanged. `field` of an error is the location, without
  /// a password.
  [[nodiscard]] static Result<std::shared_ptr<Database>> open(
      const std::string& location, Synchronous synchronous,
      int busy_timeout_ms = kDefaultBusyTimeoutMs);

  Database() = default;
  virtual ~Database() = default;
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Another connection to the same database, for another thread, without the checks made before.
  /// May be called from any thread.
  [[nodiscard]] virtual Result<std::shared_ptr<Database>> open_another(
      Synchronous synchronous) const = 0;

  /// Where the database is, without a password.
  [[nodiscard]] virtual const std::string& location() const = 0;
  /// Of what is stored, without the space that removed rows left.
  [[nodiscard]] virtual Result<std::uint64_t> used_bytes() = 0;

  /// A number that differs from the last one on this connection when a map or a token was changed
  /// by another connection, of this or another process. SQLite counts sessions too;
  /// for PostgreSQL there is SessionStore::foreign_changes().
  [[nodiscard]] virtual Result<std::int64_t> data_version() = 0;

  /// Whether the database can be read and still has the schema of this program.
  [[nodiscard]] virtual Result<void> probe() = 0;
  /// Whether a commit can be stored: makes one that changes nothing.
  [[nodiscard]] virtual Result<void> probe_write() = 0;
  /// Whether this is still the database that was opened: a file may be deleted or replaced. Any
  /// thread may call.
  [[nodiscard]] virtual Result<void> check_in_place() const = 0;
  /// kUnavailable when less than that is left on the disk of the database. No test where the disk
  /// is another machine's.
  [[nodiscard]] virtual Result<void> check_room(std::uint64_t min_free_bytes) const = 0;
  /// Reads all pages anew: kCorruptData when some are damaged. Any thread may call, beside the
  /// others. Ends early, without an error, once `is_cancelled`.
  [[nodiscard]] virtual Result<void> check_pages(const std::atomic<bool>& is_cancelled) const = 0;

  /// What follows is for the stores, which let no exception out. It throws.
  [[nodiscard]] virtual std::unique_ptr<Transaction> begin(Access access) = 0;
  [[nodiscard]] virtual MapTables& maps() = 0;
  [[nodiscard]] virtual SessionTables& sessions() = 0;
  [[nodiscard]] virtual TokenTables& tokens() = 0;
  [[nodiscard]] virtual JobTables& jobs() = 0;
  [[nodiscard]] virtual LastIds last_ids() = 0;
  virtual void set_last_ids(const LastIds& ids) = 0;
};

/// Whether `location` is that of a PostgreSQL database, not a file.
[[nodiscard]] bool is_postgresql(std::string_view location);

/// An error that leaves a function by a throw, up to guarded().
class StorageError : public std::runtime_error {
 public:
  explicit StorageError(Error error)
      : std::runtime_error(error.message), error_(std::move(error)) {}
  [[nodiscard]] const Error& error() const { return error_; }

 private:
  Error error_;
};

/// The exception being handled as an Error: kStorageFull, kUnavailable for a busy database or a
/// lost connection, kCorruptData, kConflict for what is there already, kTooLarge, else kInternal.
[[nodiscard]] Error current_error();

/// Calls `function`, which returns a Result, and turns exceptions into its error.
template <typename Function>
std::invoke_result_t<Function> guarded(Function&& function) {
  try {
    return function();
  } catch (...) {
    return current_error();
  }
}

}  // namespace cornerfix::storage

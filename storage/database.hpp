/// \file  A connection to a Cornerfix database file: opened with every check, or refused and the
/// file left as it was.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <type_traits>
#include <unordered_map>

#include <cornerfix/result.hpp>

namespace SQLite {  // NOLINT(readability-identifier-naming): the library's own name.
class Database;
class Statement;
}  // namespace SQLite

namespace cornerfix::storage {

/// What survives a power cut. A killed process loses nothing in either.
enum class Synchronous {
  kFull,    ///< Every acknowledged commit: for maps. About 4 ms a commit.
  kNormal,  ///< All but the last commits, never half of one: for sessions.
};

/// How long a connection waits for another one's write before it gives up with kUnavailable.
inline constexpr int kDefaultBusyTimeoutMs = 5000;

/// An open file of the current schema, in WAL mode with foreign keys on. Not synchronised: one
/// thread at a time. Any number of connections, of any process, may share the file.
class Database {
 public:
  /// Opens `path`, or creates it when it does not exist or is empty, and migrates older schemas.
  ///
  /// Refuses a newer schema or a file of another program (kInvalidArgument), and a damaged file or
  /// one that is not SQLite's (kCorruptData). A refused file is byte for byte what it was, and no
  /// new file lies beside it. `field` of an error is the path. Reads the whole file once.
  [[nodiscard]] static Result<std::shared_ptr<Database>> open(
      const std::filesystem::path& path, Synchronous synchronous,
      int busy_timeout_ms = kDefaultBusyTimeoutMs);

  /// Another connection to the same file, for another thread, without the checks made before.
  /// May be called from any thread.
  [[nodiscard]] Result<std::shared_ptr<Database>> open_another(Synchronous synchronous) const;

  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// A number that differs from the last one on this connection when another connection, of this
  /// or another process, has changed the file. Own changes do not count. Takes microseconds.
  [[nodiscard]] Result<std::int64_t> data_version();

  /// Of the pages that hold something.
  [[nodiscard]] Result<std::uint64_t> used_bytes();

  /// Whether the file can be read and still has the schema of this program.
  [[nodiscard]] Result<void> probe();

  /// Whether a commit can be stored: makes one that changes nothing.
  [[nodiscard]] Result<void> probe_write();

  /// Reads all pages anew from the file: kCorruptData when some are damaged. Any thread may call,
  /// beside the others. Ends early, without an error, once `is_cancelled`.
  [[nodiscard]] Result<void> check_pages(const std::atomic<bool>& is_cancelled) const;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// For the stores of this module, which let no exception of SQLiteCpp out.
  [[nodiscard]] SQLite::Database& connection() { return *connection_; }
  /// The statement for `sql`, prepared once a connection. Owned by this database.
  [[nodiscard]] SQLite::Statement& prepared(std::string_view sql);

 private:
  Database(std::filesystem::path path, Synchronous synchronous, int busy_timeout_ms);

  std::filesystem::path path_;
  int busy_timeout_ms_;
  std::unique_ptr<SQLite::Database> connection_;
  /// Keys are views of the statements' own text.
  std::unordered_map<std::string_view, std::unique_ptr<SQLite::Statement>> statements_;
};

/// The exception being handled as an Error: kStorageFull, kUnavailable for a busy file,
/// kCorruptData, kConflict for what is there already, kTooLarge, else kInternal.
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

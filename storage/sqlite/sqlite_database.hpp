/// \file  A connection to a Cornerfix database file: opened with every check, or refused and the
/// file left as it was.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <unordered_map>

#include "storage/database.hpp"

namespace SQLite {  // NOLINT(readability-identifier-naming): the library's own name.
class Database;
class Exception;
class Statement;
}  // namespace SQLite

namespace cornerfix::storage {

/// An open file of the current schema, in WAL mode with foreign keys on.
class SqliteDatabase : public Database {
 public:
  /// As Database::open(). A damaged file, or one that is not SQLite's, is kCorruptData. A refused
  /// file is byte for byte what it was, and no new file lies beside it. Reads the whole file once.
  [[nodiscard]] static Result<std::shared_ptr<SqliteDatabase>> open(
      const std::filesystem::path& path, Synchronous synchronous,
      int busy_timeout_ms = kDefaultBusyTimeoutMs);

  ~SqliteDatabase() override;

  [[nodiscard]] Result<std::shared_ptr<Database>> open_another(
      Synchronous synchronous) const override;
  [[nodiscard]] const std::string& location() const override { return path_.native(); }
  /// Own changes do not count. Takes microseconds.
  [[nodiscard]] Result<std::int64_t> data_version() override;
  [[nodiscard]] Result<void> probe() override;
  [[nodiscard]] Result<std::uint64_t> used_bytes() override;
  [[nodiscard]] Result<void> probe_write() override;
  [[nodiscard]] Result<void> check_in_place() const override;
  [[nodiscard]] Result<void> check_room(std::uint64_t min_free_bytes) const override;
  [[nodiscard]] Result<void> check_pages(const std::atomic<bool>& is_cancelled) const override;

  [[nodiscard]] std::unique_ptr<Transaction> begin(Access access) override;
  [[nodiscard]] MapTables& maps() override { return *maps_; }
  [[nodiscard]] SessionTables& sessions() override { return *sessions_; }
  [[nodiscard]] TokenTables& tokens() override { return *tokens_; }
  [[nodiscard]] JobTables& jobs() override { return *jobs_; }
  [[nodiscard]] LastIds last_ids() override;
  void set_last_ids(const LastIds& ids) override;

  [[nodiscard]] SQLite::Database& connection() { return *connection_; }
  /// The statement for `sql`, prepared once a connection. Owned by this database.
  [[nodiscard]] SQLite::Statement& prepared(std::string_view sql);
  /// Of the last INSERT.
  [[nodiscard]] std::int64_t last_row_id() const;

 private:
  /// A file as the operating system knows it: a path may come to name another one.
  struct FileId {
    std::uint64_t device = 0;
    std::uint64_t inode = 0;
    friend bool operator==(const FileId&, const FileId&) = default;
  };

  SqliteDatabase(std::filesystem::path path, Synchronous synchronous, int busy_timeout_ms);
  [[nodiscard]] static std::optional<FileId> id_of(const std::filesystem::path& path);
  void remember_files();

  std::filesystem::path path_;
  int busy_timeout_ms_;
  std::unique_ptr<SQLite::Database> connection_;
  /// Keys are views of the statements' own text.
  std::unordered_map<std::string_view, std::unique_ptr<SQLite::Statement>> statements_;
  std::unique_ptr<MapTables> maps_;
  std::unique_ptr<SessionTables> sessions_;
  std::unique_ptr<TokenTables> tokens_;
  std::unique_ptr<JobTables> jobs_;
  /// The database, its write-ahead log and its index.
  std::array<std::filesystem::path, 3> files_;
  std::array<std::optional<FileId>, 3> opened_;
};

/// What an exception of SQLiteCpp means.
[[nodiscard]] Error error_of(const SQLite::Exception& exception);

}  // namespace cornerfix::storage

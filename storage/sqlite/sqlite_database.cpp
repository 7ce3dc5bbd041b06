#include "storage/sqlite/sqlite_database.hpp"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "storage/sqlite/schema.hpp"
#include "storage/sqlite/sqlite_tables.hpp"

namespace cornerfix::storage {
namespace {

namespace fs = std::filesystem;

ErrorCode code_of(const SQLite::Exception& exception) {
  switch (exception.getExtendedErrorCode()) {
    case SQLITE_IOERR_SHMSIZE:  // How a full disk shows when the WAL's index cannot grow.
      return ErrorCode::kStorageFull;
    case SQLITE_CONSTRAINT_PRIMARYKEY:
    case SQLITE_CONSTRAINT_UNIQUE:
      return ErrorCode::kConflict;
    default:
      break;
  }
  switch (exception.getErrorCode()) {
    case SQLITE_FULL:
      return ErrorCode::kStorageFull;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return ErrorCode::kCorruptData;
    case SQLITE_TOOBIG:
      return ErrorCode::kTooLarge;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_CANTOPEN:
    case SQLITE_IOERR:
    case SQLITE_PERM:
    case SQLITE_READONLY:
      return ErrorCode::kUnavailable;
    default:
      return ErrorCode::kInternal;
  }
}

/// The same file, with a suffix of SQLite's companions.
fs::path companion(const fs::path& path, const char* suffix) {
  fs::path name = path;
  name += suffix;
  return name;
}

/// Whether a write may be going on, or was broken off: the file alone is then incomplete.
bool has_companions(const fs::path& path) {
  return fs::exists(companion(path, "-wal")) || fs::exists(companion(path, "-journal"));
}

/// An SQLite URI that opens the file without locks, companions or a write of any kind.
std::string immutable_uri(const fs::path& path) {
  std::string uri = "file:";
  for (const char c : path.string()) {
    if (c == '%') {
      uri += "%25";
    } else if (c == '?') {
      uri += "%3f";
    } else if (c == '#') {
      uri += "%23";
    } else {
      uri += c;
    }
  }
  return uri + "?immutable=1";
}

/// Reads application_id from the file's header (bytes 68 to 71, SQLite file format 1.3), which a
/// checkpoint that was interrupted leaves intact. SQLite without the WAL would refuse such a file,
/// because its header may count pages that are still in the WAL.
Result<void> check_owner(const fs::path& path) {
  constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);
  constexpr std::size_t kOwnerOffset = 68;
  std::array<char, 100> header{};
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kUnavailable, "cannot be opened for reading", ""};
  file.read(header.data(), header.size());
  if (file.gcount() < static_cast<std::streamsize>(header.size()) ||
      !std::string_view(header.data(), header.size()).starts_with(kSqliteMagic)) {
    return Error{ErrorCode::kCorruptData, "file is not a database", ""};
  }
  std::uint32_t owner = 0;
  for (std::size_t i = 0; i < 4; ++i)
    owner = owner << 8U | static_cast<unsigned char>(header.at(kOwnerOffset + i));
  if (owner == kApplicationId) return {};
  return Error{ErrorCode::kInvalidArgument,
               "the file is not a Cornerfix database: its application_id is " +
                   std::to_string(owner) + ", expected " + std::to_string(kApplicationId),
               ""};
}

Result<void> check_content(SQLite::Database& connection) {
  Result<void> known = check_schema_version(user_version(connection), schema_version());
  if (!known) return known;
  const std::string found = connection.execAndGet("PRAGMA quick_check(1)").getString();
  if (found == "ok") return {};
  return Error{ErrorCode::kCorruptData, "the database is damaged: " + found, ""};
}

/// Checks a file that has companions, through them, without ever merging them into it.
Result<void> check_with_companions(const fs::path& path, bool alone, int busy_timeout_ms) {
  return guarded([&]() -> Result<void> {
    SQLite::Database connection(path.string(), SQLite::OPEN_READWRITE, busy_timeout_ms);
    sqlite3_db_config(connection.getHandle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
    // Alone, SQLite keeps the WAL's index in memory instead of a new -shm file.
    if (alone) connection.exec("PRAGMA locking_mode = EXCLUSIVE");
    return check_content(connection);
  });
}

/// Nothing when `path` may be opened for writing. Changes neither the file nor its directory.
Result<void> check_file(const fs::path& path, int busy_timeout_ms) {
  if (fs::is_directory(path)) return Error{ErrorCode::kInvalidArgument, "is a directory", ""};
  if (!fs::exists(path) || (fs::is_regular_file(path) && fs::file_size(path) == 0)) return {};

  if (Result<void> ours = check_owner(path); !ours) return ours;
  if (!has_companions(path)) {
    Result<void> sound = guarded([&] {
      SQLite::Database connection(immutable_uri(path), SQLite::OPEN_READONLY | SQLite::OPEN_URI);
      return check_content(connection);
    });
    // A process that opened the file since may have written while we read.
    if (sound || !has_companions(path)) return sound;
  }
  Result<void> sound = check_with_companions(path, true, 0);
  const bool is_open_elsewhere = !sound && sound.error().code == ErrorCode::kUnavailable;
  return is_open_elsewhere ? check_with_companions(path, false, busy_timeout_ms) : sound;
}

/// The journal mode after the change to WAL. SQLite does not wait for other connections here, in
/// spite of its time-out, so this does.
std::string switch_to_wal(SQLite::Database& connection, int busy_timeout_ms) {
  constexpr int kPauseMs = 10;
  for (int waited_ms = 0;; waited_ms += sqlite3_sleep(kPauseMs)) {
    try {
      return connection.execAndGet("PRAGMA journal_mode = WAL").getString();
    } catch (const SQLite::Exception& exception) {
      if (exception.getErrorCode() != SQLITE_BUSY || waited_ms >= busy_timeout_ms) throw;
    }
  }
}

Error at_path(Error error, const fs::path& path) {
  error.field = path.string();
  return error;
}

}  // namespace

Error error_of(const SQLite::Exception& exception) {
  return Error{code_of(exception), std::string("database: ") + exception.what(), ""};
}

SqliteDatabase::SqliteDatabase(fs::path path, Synchronous synchronous, int busy_timeout_ms)
    : path_(std::move(path)),
      busy_timeout_ms_(busy_timeout_ms),
      connection_(std::make_unique<SQLite::Database>(
          path_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLite::OPEN_NOMUTEX,
          busy_timeout_ms)) {
  connection_->exec("PRAGMA foreign_keys = ON");
  connection_->exec(synchronous == Synchronous::kFull ? "PRAGMA synchronous = FULL"
                                                      : "PRAGMA synchronous = NORMAL");
  if (synchronous == Synchronous::kNormal) connection_->exec("PRAGMA wal_autocheckpoint = 8000");
  maps_ = make_map_tables(*this);
  sessions_ = make_session_tables(*this);
  tokens_ = make_token_tables(*this);
  jobs_ = make_job_tables(*this);
}

SqliteDatabase::~SqliteDatabase() = default;

Result<std::shared_ptr<SqliteDatabase>> SqliteDatabase::open(const fs::path& path,
                                                             Synchronous synchronous,
                                                             int busy_timeout_ms) {
  auto opened = guarded([&]() -> Result<std::shared_ptr<SqliteDatabase>> {
    // Absolute, so that no name (":memory:", "file:…") means anything but a file.
    const fs::path file = fs::absolute(path).lexically_normal();
    if (Result<void> sound = check_file(file, busy_timeout_ms); !sound) return sound.error();
    std::shared_ptr<SqliteDatabase> database(
        new SqliteDatabase(file, synchronous, busy_timeout_ms));
    // Before WAL, so that the file itself says from its first byte on whose it is.
    if (Result<void> done = migrate(database->connection(), migrations()); !done) {
      return done.error();
    }
    const std::string mode = switch_to_wal(database->connection(), busy_timeout_ms);
    if (mode != "wal") {
      return Error{ErrorCode::kUnavailable, "this file system cannot hold a WAL database", ""};
    }
    database->remember_files();
    return database;
  });
  if (!opened) return at_path(opened.error(), path);
  return opened;
}

Result<std::shared_ptr<Database>> SqliteDatabase::open_another(Synchronous synchronous) const {
  auto opened = guarded([&]() -> Result<std::shared_ptr<Database>> {
    std::shared_ptr<SqliteDatabase> another(
        new SqliteDatabase(path_, synchronous, busy_timeout_ms_));
    another->remember_files();
    return std::shared_ptr<Database>(std::move(another));
  });
  if (!opened) return at_path(opened.error(), path_);
  return opened;
}

Result<std::int64_t> SqliteDatabase::data_version() {
  return guarded([&]() -> Result<std::int64_t> {
    SQLite::Statement& statement = prepared("PRAGMA data_version");
    statement.executeStep();
    const std::int64_t version = statement.getColumn(0).getInt64();
    statement.reset();
    return version;
  });
}

Result<void> SqliteDatabase::probe() {
  return guarded([&]() -> Result<void> {
    const std::int64_t found = user_version(*connection_);
    if (found == schema_version()) return {};
    return Error{ErrorCode::kUnavailable,
                 "the database has been migrated to schema " + std::to_string(found) +
                     ", this program writes " + std::to_string(schema_version()),
                 path_.string()};
  });
}

Result<std::uint64_t> SqliteDatabase::used_bytes() {
  return guarded([&]() -> Result<std::uint64_t> {
    const auto number = [&](const char* pragma) {
      return connection_->execAndGet(std::string("PRAGMA ") + pragma).getInt64();
    };
    const std::int64_t pages = number("page_count") - number("freelist_count");
    return static_cast<std::uint64_t>(pages * number("page_size"));
  });
}

Result<void> SqliteDatabase::probe_write() {
  return guarded([&]() -> Result<void> {
    SQLite::Transaction transaction(*connection_, SQLite::TransactionBehavior::IMMEDIATE);
    // Writes the first page, although the number stays the same.
    connection_->exec("PRAGMA user_version = " + std::to_string(user_version(*connection_)));
    transaction.commit();
    return {};
  });
}

std::optional<SqliteDatabase::FileId> SqliteDatabase::id_of(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return FileId{status.st_dev, status.st_ino};
}

void SqliteDatabase::remember_files() {
  // The first read opens the companions. They stay as long as a connection is open.
  (void)user_version(*connection_);
  files_ = {path_, companion(path_, "-wal"), companion(path_, "-shm")};
  std::ranges::transform(files_, opened_.begin(), id_of);
}

Result<void> SqliteDatabase::check_in_place() const {
  for (std::size_t i = 0; i < files_.size(); ++i) {
    if (opened_.at(i) && id_of(files_.at(i)) == opened_.at(i)) continue;
    return Error{ErrorCode::kUnavailable,
                 "the database file " + files_.at(i).filename().string() +
                     " was deleted or replaced while the server was running: restart the server",
                 ""};
  }
  return {};
}

Result<void> SqliteDatabase::check_room(std::uint64_t min_free_bytes) const {
  std::error_code error;
  const auto space = fs::space(path_, error);
  if (error || space.available >= min_free_bytes) return {};
  return Error{ErrorCode::kUnavailable,
               "the disk of the database has " + std::to_string(space.available) +
                   " bytes left, expected at least " + std::to_string(min_free_bytes),
               ""};
}

Result<void> SqliteDatabase::check_pages(const std::atomic<bool>& is_cancelled) const {
  constexpr int kInstructionsBetweenLooks = 10'000;
  const auto is_asked_to_end = [](void* flag) {
    return static_cast<const std::atomic<bool>*>(flag)->load() ? 1 : 0;
  };
  Result<void> checked = guarded([&]() -> Result<void> {
    SQLite::Database connection(path_.string(), SQLite::OPEN_READONLY, busy_timeout_ms_);
    sqlite3_progress_handler(connection.getHandle(), kInstructionsBetweenLooks, is_asked_to_end,
                             const_cast<std::atomic<bool>*>(&is_cancelled));
    return check_content(connection);
  });
  return is_cancelled ? Result<void>() : checked;
}

namespace {

/// Holds the file's one write lock from its start when it writes, since a lock taken later can fail
/// as busy in spite of the time-out.
class SqliteTransaction : public Transaction {
 public:
  SqliteTransaction(SQLite::Database& connection, Access access)
      : transaction_(connection, access == Access::kWrite ? SQLite::TransactionBehavior::IMMEDIATE
                                                          : SQLite::TransactionBehavior::DEFERRED) {
  }
  void commit() override { transaction_.commit(); }

 private:
  SQLite::Transaction transaction_;
};

}  // namespace

std::unique_ptr<Transaction> SqliteDatabase::begin(Access access) {
  return std::make_unique<SqliteTransaction>(*connection_, access);
}

LastIds SqliteDatabase::last_ids() {
  const auto last = [&](const char* table) {
    SQLite::Statement& statement = prepared("SELECT seq FROM sqlite_sequence WHERE name = ?");
    statement.reset();
    statement.bind(1, table);
    const std::int64_t id = statement.executeStep() ? statement.getColumn(0).getInt64() : 0;
    statement.reset();
    return id;
  };
  return {.map = last("maps"), .session = last("sessions"), .token = last("tokens")};
}

void SqliteDatabase::set_last_ids(const LastIds& ids) {
  const auto set = [&](const char* table, std::int64_t id) {
    SQLite::Statement remove(*connection_, "DELETE FROM sqlite_sequence WHERE name = ?");
    remove.bind(1, table);
    remove.exec();
    SQLite::Statement insert(*connection_, "INSERT INTO sqlite_sequence (name, seq) VALUES (?, ?)");
    insert.bind(1, table);
    insert.bind(2, id);
    insert.exec();
  };
  set("maps", ids.map);
  set("sessions", ids.session);
  set("tokens", ids.token);
}

std::int64_t SqliteDatabase::last_row_id() const { return connection_->getLastInsertRowid(); }

SQLite::Statement& SqliteDatabase::prepared(std::string_view sql) {
  if (const auto found = statements_.find(sql); found != statements_.end()) return *found->second;
  auto statement = std::make_unique<SQLite::Statement>(*connection_, std::string(sql));
  const std::string_view key = statement->getQuery();
  return *statements_.emplace(key, std::move(statement)).first->second;
}

}  // namespace cornerfix::storage

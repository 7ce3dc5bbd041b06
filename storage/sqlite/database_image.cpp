#include "storage/sqlite/database_image.hpp"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <sqlite3.h>

#include <cstring>
#include <new>
#include <tuple>
#include <utility>

#include "storage/database.hpp"

namespace cornerfix::storage {
namespace {

constexpr std::string_view kMagic{"SQLite format 3\0", 16};
constexpr int kMaxBlobBytes = 1 << 28;
constexpr int kMaxSqlBytes = 10'000;

Error malformed(std::string message) {
  return {ErrorCode::kMalformed, std::move(message), "archive"};
}

Error of_another_kind(std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message), "archive"};
}

/// All that a schema holds, in an order that does not depend on when it was made.
std::vector<std::tuple<std::string, std::string, std::string>> schema_of(
    SQLite::Database& database) {
  std::vector<std::tuple<std::string, std::string, std::string>> entries;
  SQLite::Statement statement(
      database, "SELECT type, name, ifnull(sql, '') FROM sqlite_schema ORDER BY 1, 2");
  while (statement.executeStep()) {
    entries.emplace_back(statement.getColumn(0).getString(), statement.getColumn(1).getString(),
                         statement.getColumn(2).getString());
  }
  return entries;
}

void distrust(sqlite3* handle) {
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, kMaxBlobBytes);
  sqlite3_limit(handle, SQLITE_LIMIT_SQL_LENGTH, kMaxSqlBytes);
  sqlite3_limit(handle, SQLITE_LIMIT_ATTACHED, 0);
}

/// Puts a copy of the bytes in place of the database's content.
void load(SQLite::Database& database, std::span<const std::uint8_t> bytes) {
  auto* copy = static_cast<unsigned char*>(sqlite3_malloc64(bytes.size()));
  if (copy == nullptr) throw std::bad_alloc();
  std::memcpy(copy, bytes.data(), bytes.size());
  const auto size = static_cast<sqlite3_int64>(bytes.size());
  const int code =
      sqlite3_deserialize(database.getHandle(), "main", copy, size, size,
                          SQLITE_DESERIALIZE_FREEONCLOSE | SQLITE_DESERIALIZE_READONLY);
  if (code != SQLITE_OK) throw SQLite::Exception(database.getHandle(), code);
}

std::int64_t pragma(SQLite::Database& database, const char* name) {
  return database.execAndGet(std::string("PRAGMA ") + name).getInt64();
}

Result<void> check(SQLite::Database& database, const ImageKind& kind, std::size_t size) {
  if (pragma(database, "application_id") != kind.application_id)
    return of_another_kind("the file is not an archive of a map: its application_id is another");
  const std::int64_t version = pragma(database, "user_version");
  if (version != kind.version) {
    return of_another_kind("the archive has version " + std::to_string(version) +
                           ", this program knows " + std::to_string(kind.version));
  }
  if (schema_of(database) != schema_of(*make_image(kind)))
    return of_another_kind("the archive's tables are not those of an archive");
  // SQLite would read what is missing of the last page as zeros.
  const std::int64_t expected = pragma(database, "page_count") * pragma(database, "page_size");
  if (expected != static_cast<std::int64_t>(size)) {
    return malformed("the archive has " + std::to_string(size) + " bytes, expected " +
                     std::to_string(expected));
  }
  const std::string found = database.execAndGet("PRAGMA integrity_check(1)").getString();
  if (found != "ok") return malformed("the archive is damaged: " + found);
  return {};
}

}  // namespace

std::unique_ptr<SQLite::Database> make_image(const ImageKind& kind) {
  auto database = std::make_unique<SQLite::Database>(":memory:", SQLite::OPEN_READWRITE);
  database->exec("PRAGMA application_id = " + std::to_string(kind.application_id));
  database->exec("PRAGMA user_version = " + std::to_string(kind.version));
  database->exec(kind.schema);
  return database;
}

std::vector<std::uint8_t> bytes_of(SQLite::Database& database) {
  sqlite3_int64 size = 0;
  unsigned char* bytes = sqlite3_serialize(database.getHandle(), "main", &size, 0);
  if (bytes == nullptr) throw std::bad_alloc();
  const std::unique_ptr<unsigned char, decltype(&sqlite3_free)> owner(bytes, &sqlite3_free);
  return {bytes, bytes + size};
}

Result<std::unique_ptr<SQLite::Database>> open_untrusted_image(std::span<const std::uint8_t> bytes,
                                                               const ImageKind& kind) {
  if (bytes.size() < 512 || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0)
    return malformed("the file is not an SQLite file");
  auto opened = guarded([&]() -> Result<std::unique_ptr<SQLite::Database>> {
    auto database = std::make_unique<SQLite::Database>(":memory:", SQLite::OPEN_READWRITE);
    distrust(database->getHandle());
    load(*database, bytes);
    database->exec("PRAGMA cell_size_check = ON");
    if (const Result<void> sound = check(*database, kind, bytes.size()); !sound)
      return sound.error();
    return database;
  });
  // Any fault of the bytes is that of their sender, not of our own file.
  if (!opened && opened.error().field != "archive") return malformed(opened.error().message);
  return opened;
}

}  // namespace cornerfix::storage

#include "storage/sqlite/backup.hpp"

#include <SQLiteCpp/Backup.h>
#include <SQLiteCpp/Database.h>

#include <string>
#include <system_error>

#include "storage/database.hpp"
#include "storage/sqlite/schema.hpp"

namespace cornerfix::storage {
namespace {

namespace fs = std::filesystem;

Result<void> copy_and_check(const fs::path& source, const fs::path& target) {
  return guarded([&]() -> Result<void> {
    SQLite::Database from(source.string(), SQLite::OPEN_READONLY, kDefaultBusyTimeoutMs);
    SQLite::Database to(target.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    SQLite::Backup(to, from).executeStep();
    // The copy is one file, for any journal of the source.
    to.exec("PRAGMA journal_mode = DELETE");
    if (to.execAndGet("PRAGMA application_id").getInt64() != kApplicationId)
      return Error{ErrorCode::kInvalidArgument, "is not a Cornerfix database", source.string()};
    const std::string found = to.execAndGet("PRAGMA integrity_check(1)").getString();
    if (found == "ok") return {};
    return Error{ErrorCode::kCorruptData, "the database is damaged: " + found, source.string()};
  });
}

}  // namespace

Result<void> back_up(const fs::path& source, const fs::path& target) {
  std::error_code error;
  if (!fs::exists(source, error))
    return Error{ErrorCode::kNotFound, "does not exist", source.string()};
  if (fs::exists(target, error))
    return Error{ErrorCode::kConflict, "exists already", target.string()};
  fs::path partial = target;
  partial += ".partial";
  fs::remove(partial, error);
  Result<void> done = copy_and_check(source, partial);
  if (!done && done.error().field.empty())
    done = Error{done.error().code, "to " + target.string() + ": " + done.error().message,
                 source.string()};
  if (done) {
    fs::rename(partial, target, error);
    if (!error) return done;
    done = Error{ErrorCode::kUnavailable, error.message(), target.string()};
  }
  fs::remove(partial, error);
  return done;
}

}  // namespace cornerfix::storage

#include "storage/database.hpp"

#include <SQLiteCpp/Exception.h>

#include <exception>

#include "storage/postgresql/postgresql_database.hpp"
#include "storage/sqlite/sqlite_database.hpp"

namespace cornerfix::storage {

bool is_postgresql(std::string_view location) {
  return location.starts_with("postgresql://") || location.starts_with("postgres://");
}

Result<std::shared_ptr<Database>> Database::open(const std::string& location,
                                                 Synchronous synchronous, int busy_timeout_ms) {
  if (is_postgresql(location)) return open_postgresql(location, synchronous, busy_timeout_ms);
  auto file = SqliteDatabase::open(location, synchronous, busy_timeout_ms);
  if (!file) return file.error();
  return std::shared_ptr<Database>(std::move(*file));
}

Error current_error() {
  try {
    throw;
  } catch (const StorageError& exception) {
    return exception.error();
  } catch (const SQLite::Exception& exception) {
    return error_of(exception);
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kInternal, std::string("storage: ") + exception.what(), ""};
  }
}

}  // namespace cornerfix::storage

#include "server/store_access.hpp"

#include <sys/stat.h>

#include <optional>
#include <string>
#include <system_error>

namespace cornerfix::server {

using storage::Database;
using storage::Synchronous;

namespace {

std::optional<FileId> id_of(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return FileId{status.st_dev, status.st_ino};
}

Error not_in_place() {
  return {ErrorCode::kUnavailable,
          "the database file was deleted or replaced while the server was running: restart the "
          "server",
          ""};
}

}  // namespace

Result<std::shared_ptr<StoreAccess>> StoreAccess::open(const std::filesystem::path& path,
                                                       int busy_timeout_ms) {
  auto map_database = Database::open(path, Synchronous::kFull, busy_timeout_ms);
  if (!map_database) return map_database.error();
  auto session_database = (*map_database)->open_another(Synchronous::kNormal);
  if (!session_database) return session_database.error();
  const auto opened = id_of((*map_database)->path());
  if (!opened) return not_in_place();
  return std::shared_ptr<StoreAccess>(
      new StoreAccess(std::move(*map_database), std::move(*session_database), *opened));
}

StoreAccess::StoreAccess(std::shared_ptr<Database> map_database,
                         std::shared_ptr<Database> session_database, FileId opened)
    : path_(map_database->path()),
      opened_(opened),
      maps_(map_database),
      session_list_(std::move(map_database)),
      session_database_(std::move(session_database)),
      sessions_(session_database_),
      map_entries_(session_database_),
      tokens_(session_database_),
      page_check_(session_database_) {}

Result<std::vector<storage::TokenRecord>> StoreAccess::tokens() {
  const std::lock_guard lock(session_mutex_);
  return tokens_.list();
}

Result<std::uint64_t> StoreAccess::epoch() {
  const std::lock_guard lock(session_mutex_);
  if (const auto in_place = check_in_place(); !in_place) return in_place.error();
  const auto version = session_database_->data_version();
  if (!version) return version.error();
  if (*version != data_version_) ++epoch_;
  data_version_ = *version;
  return epoch_;
}

Result<void> StoreAccess::probe(std::uint64_t min_free_bytes) {
  {
    const std::lock_guard lock(session_mutex_);
    if (auto in_place = check_in_place(); !in_place) return in_place;
    if (auto readable = session_database_->probe(); !readable) return readable;
    if (auto room = check_room(min_free_bytes); !room) return room;
    auto stored = write_check_.result([this] { return session_database_->probe_write(); });
    if (!stored) return stored;
  }
  return page_check_.result();
}

Result<void> StoreAccess::check_room(std::uint64_t min_free_bytes) const {
  std::error_code error;
  const auto space = std::filesystem::space(path_, error);
  if (error || space.available >= min_free_bytes) return {};
  return Error{ErrorCode::kUnavailable,
               "the disk of the database has " + std::to_string(space.available) +
                   " bytes left, expected at least " + std::to_string(min_free_bytes),
               ""};
}

Result<void> StoreAccess::check_in_place() const {
  if (id_of(path_) == opened_) return {};
  return not_in_place();
}

}  // namespace cornerfix::server

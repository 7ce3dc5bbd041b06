#include "server/store_access.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cstddef>
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

Error not_in_place(const std::filesystem::path& file) {
  return {ErrorCode::kUnavailable,
          "the database file " + file.filename().string() +
              " was deleted or replaced while the server was running: restart the server",
          ""};
}

/// The file and SQLite's companions of it.
std::array<std::filesystem::path, 3> files_of(const std::filesystem::path& path) {
  return {path, path.string() + "-wal", path.string() + "-shm"};
}

}  // namespace

Result<std::shared_ptr<StoreAccess>> StoreAccess::open(const std::filesystem::path& path,
                                                       int busy_timeout_ms) {
  auto map_database = Database::open(path, Synchronous::kFull, busy_timeout_ms);
  if (!map_database) return map_database.error();
  auto session_database = (*map_database)->open_another(Synchronous::kNormal);
  if (!session_database) return session_database.error();
  // The first read opens the companions. They stay as long as a connection is open.
  if (const auto readable = (*session_database)->probe(); !readable) return readable.error();
  return std::shared_ptr<StoreAccess>(new StoreAccess(std::move(*map_database),
                                                      std::move(*session_database),
                                                      std::chrono::milliseconds(busy_timeout_ms)));
}

StoreAccess::StoreAccess(std::shared_ptr<Database> map_database,
                         std::shared_ptr<Database> session_database,
                         std::chrono::milliseconds patience)
    : path_(map_database->path()),
      files_(files_of(path_)),
      maps_(map_database),
      session_list_(std::move(map_database)),
      patience_(patience),
      session_database_(std::move(session_database)),
      sessions_(session_database_),
      map_entries_(session_database_),
      tokens_(session_database_),
      page_check_(session_database_) {
  std::ranges::transform(files_, opened_.begin(), id_of);
}

Result<std::vector<storage::TokenRecord>> StoreAccess::tokens() {
  const std::unique_lock lock(session_mutex_, patience_);
  if (!lock) return busy();
  return tokens_.list();
}

Result<std::uint64_t> StoreAccess::used_bytes() {
  const std::unique_lock lock(session_mutex_, patience_);
  if (!lock) return busy();
  return session_database_->used_bytes();
}

Result<std::uint64_t> StoreAccess::epoch() {
  const std::unique_lock lock(session_mutex_, patience_);
  if (!lock) return busy();
  if (const auto in_place = check_in_place(); !in_place) return in_place.error();
  const auto version = session_database_->data_version();
  if (!version) return version.error();
  if (*version != data_version_) ++epoch_;
  data_version_ = *version;
  return epoch_;
}

Result<void> StoreAccess::probe(std::uint64_t min_free_bytes) {
  {
    const std::unique_lock lock(session_mutex_, patience_);
    if (!lock) return busy();
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

Error StoreAccess::busy() {
  return {ErrorCode::kUnavailable, "the database is busy: perhaps another process has locked it",
          ""};
}

Result<void> StoreAccess::check_in_place() const {
  for (std::size_t i = 0; i < files_.size(); ++i) {
    if (!opened_.at(i) || id_of(files_.at(i)) != opened_.at(i)) return not_in_place(files_.at(i));
  }
  return {};
}

}  // namespace cornerfix::server

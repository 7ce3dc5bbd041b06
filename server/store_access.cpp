#include "server/store_access.hpp"

#include <string>

namespace cornerfix::server {

using storage::Database;
using storage::Synchronous;

Result<std::shared_ptr<StoreAccess>> StoreAccess::open(const std::string& location,
                                                       int busy_timeout_ms,
                                                       std::size_t kept_revisions) {
  auto map_database = Database::open(location, Synchronous::kFull, busy_timeout_ms);
  if (!map_database) return map_database.error();
  auto session_database = (*map_database)->open_another(Synchronous::kNormal);
  if (!session_database) return session_database.error();
  if (const auto readable = (*session_database)->probe(); !readable) return readable.error();
  return std::shared_ptr<StoreAccess>(
      new StoreAccess(std::move(*map_database), std::move(*session_database),
                      std::chrono::milliseconds(busy_timeout_ms), kept_revisions));
}

StoreAccess::StoreAccess(std::shared_ptr<Database> map_database,
                         std::shared_ptr<Database> session_database,
                         std::chrono::milliseconds patience, std::size_t kept_revisions)
    : map_database_(std::move(map_database)),
      maps_(map_database_, kept_revisions),
      session_list_(map_database_),
      jobs_(map_database_),
      patience_(patience),
      session_database_(std::move(session_database)),
      sessions_(session_database_),
      map_entries_(session_database_),
      tokens_(session_database_),
      job_leases_(session_database_),
      page_check_(session_database_) {}

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
  return read_epoch();
}

Result<std::uint64_t> StoreAccess::epoch(std::string_view session) {
  const std::unique_lock lock(session_mutex_, patience_);
  if (!lock) return busy();
  const auto epoch = read_epoch();
  if (!epoch) return epoch.error();
  const auto foreign_changes = sessions_.foreign_changes(session);
  if (!foreign_changes) return foreign_changes.error();
  return *epoch + *foreign_changes;  // Both only grow.
}

Result<std::uint64_t> StoreAccess::read_epoch() {
  if (const auto in_place = session_database_->check_in_place(); !in_place) return in_place.error();
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
    if (auto in_place = session_database_->check_in_place(); !in_place) return in_place;
    if (auto readable = session_database_->probe(); !readable) return readable;
    if (auto room = session_database_->check_room(min_free_bytes); !room) return room;
    auto stored = write_check_.result([this] { return session_database_->probe_write(); });
    if (!stored) return stored;
  }
  return page_check_.result();
}

Error StoreAccess::busy() {
  return {ErrorCode::kUnavailable, "the database is busy: perhaps another process has locked it",
          ""};
}

}  // namespace cornerfix::server

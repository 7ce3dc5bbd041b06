#include "server/store_access.hpp"

namespace cornerfix::server {

using storage::Database;
using storage::Synchronous;

Result<std::shared_ptr<StoreAccess>> StoreAccess::open(const std::filesystem::path& path) {
  auto map_database = Database::open(path, Synchronous::kFull);
  if (!map_database) return map_database.error();
  auto session_database = (*map_database)->open_another(Synchronous::kNormal);
  if (!session_database) return session_database.error();
  return std::shared_ptr<StoreAccess>(
      new StoreAccess(std::move(*map_database), std::move(*session_database)));
}

StoreAccess::StoreAccess(std::shared_ptr<Database> map_database,
                         std::shared_ptr<Database> session_database)
    : maps_(map_database),
      session_list_(std::move(map_database)),
      session_database_(std::move(session_database)),
      sessions_(session_database_),
      map_entries_(session_database_) {}

Result<std::uint64_t> StoreAccess::epoch() {
  const std::lock_guard lock(session_mutex_);
  const auto version = session_database_->data_version();
  if (!version) return version.error();
  if (*version != data_version_) ++epoch_;
  data_version_ = *version;
  return epoch_;
}

Result<void> StoreAccess::probe() {
  const std::lock_guard lock(session_mutex_);
  return session_database_->probe();
}

}  // namespace cornerfix::server

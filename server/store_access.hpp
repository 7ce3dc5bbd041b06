/// \file  The two connections of the service to its database file, each used by one thread at a
/// time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <utility>

#include <cornerfix/result.hpp>

#include "storage/database.hpp"
#include "storage/map_store.hpp"
#include "storage/session_store.hpp"

namespace cornerfix::server {

/// Sessions are written often and may lose their last batches in a power cut; maps are written
/// seldom and must not. So each has a connection of its own, and quick answers to robots do not
/// wait for the writing of a map. Any threads may call.
class StoreAccess {
 public:
  [[nodiscard]] static Result<std::shared_ptr<StoreAccess>> open(const std::filesystem::path& path);

  /// `use(MapStore&)` on the connection for maps.
  template <typename Use>
  auto with_maps(Use&& use) {
    const std::lock_guard lock(map_mutex_);
    return std::forward<Use>(use)(maps_);
  }

  /// `use(SessionStore&)` on the connection for sessions.
  template <typename Use>
  auto with_sessions(Use&& use) {
    const std::lock_guard lock(session_mutex_);
    return std::forward<Use>(use)(sessions_);
  }

  /// `use(SessionStore&)` on the connection for maps: for long reads that no robot should wait for.
  template <typename Use>
  auto with_session_list(Use&& use) {
    const std::lock_guard lock(map_mutex_);
    return std::forward<Use>(use)(session_list_);
  }

  /// `use(MapStore&)` on the connection for sessions: for short reads on a robot's way.
  template <typename Use>
  auto with_map_entries(Use&& use) {
    const std::lock_guard lock(session_mutex_);
    return std::forward<Use>(use)(map_entries_);
  }

  /// Grows whenever the file was changed by anything but the sessions of this process: by this
  /// process' maps or by another process. What was read before is then to be read again.
  [[nodiscard]] Result<std::uint64_t> epoch();

  /// Whether the file can still be read.
  [[nodiscard]] Result<void> probe();

 private:
  StoreAccess(std::shared_ptr<storage::Database> map_database,
              std::shared_ptr<storage::Database> session_database);

  std::mutex map_mutex_;
  storage::MapStore maps_;
  storage::SessionStore session_list_;

  std::mutex session_mutex_;
  std::shared_ptr<storage::Database> session_database_;
  storage::SessionStore sessions_;
  storage::MapStore map_entries_;
  std::int64_t data_version_ = -1;
  std::uint64_t epoch_ = 0;
};

}  // namespace cornerfix::server

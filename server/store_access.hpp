/// \file  The two connections of the service to its database, each used by one thread at a time.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <cornerfix/result.hpp>

#include "server/store_health.hpp"
#include "storage/database.hpp"
#include "storage/job_store.hpp"
#include "storage/map_store.hpp"
#include "storage/session_store.hpp"
#include "storage/token_store.hpp"

namespace cornerfix::server {

/// Sessions are written often and may lose their last batches in a power cut; maps are written
/// seldom and must not. So each has a connection of its own, and quick answers to robots do not
/// wait for the writing of a map. Every call is kUnavailable when the file of SQLite, its
/// write-ahead log or the log's index was deleted or replaced: what was written would be lost. A
/// call about sessions waits `busy_timeout_ms` at most for those before it, else it is kUnavailable
/// too: another process may have locked the file. Any threads may call.
class StoreAccess {
 public:
  [[nodiscard]] static Result<std::shared_ptr<StoreAccess>> open(
      const std::string& location, int busy_timeout_ms = storage::kDefaultBusyTimeoutMs,
      std::size_t kept_revisions = storage::kDefaultKeptRevisions);

  /// A file, or a URL without its password.
  [[nodiscard]] const std::string& location() const { return session_database_->location(); }

  /// `use(MapStore&)` on the connection for maps.
  template <typename Use>
  std::invoke_result_t<Use, storage::MapStore&> with_maps(Use&& use) {
    const std::lock_guard lock(map_mutex_);
    if (const auto in_place = map_database_->check_in_place(); !in_place) return in_place.error();
    return std::forward<Use>(use)(maps_);
  }

  /// `use(SessionStore&)` on the connection for sessions.
  template <typename Use>
  std::invoke_result_t<Use, storage::SessionStore&> with_sessions(Use&& use) {
    const std::unique_lock lock(session_mutex_, patience_);
    if (!lock) return busy();
    if (const auto in_place = map_database_->check_in_place(); !in_place) return in_place.error();
    return std::forward<Use>(use)(sessions_);
  }

  /// `use(SessionStore&)` on the connection for maps: for long reads that no robot should wait for.
  template <typename Use>
  std::invoke_result_t<Use, storage::SessionStore&> with_session_list(Use&& use) {
    const std::lock_guard lock(map_mutex_);
    if (const auto in_place = map_database_->check_in_place(); !in_place) return in_place.error();
    return std::forward<Use>(use)(session_list_);
  }

  /// `use(MapStore&)` on the connection for sessions: for short reads on a robot's way.
  template <typename Use>
  std::invoke_result_t<Use, storage::MapStore&> with_map_entries(Use&& use) {
    const std::unique_lock lock(session_mutex_, patience_);
    if (!lock) return busy();
    if (const auto in_place = map_database_->check_in_place(); !in_place) return in_place.error();
    return std::forward<Use>(use)(map_entries_);
  }

  /// `use(JobStore&)` on the connection for maps.
  template <typename Use>
  std::invoke_result_t<Use, storage::JobStore&> with_jobs(Use&& use) {
    const std::lock_guard lock(map_mutex_);
    if (const auto in_place = map_database_->check_in_place(); !in_place) return in_place.error();
    return std::forward<Use>(use)(jobs_);
  }

  /// `use(JobStore&)` on the connection for sessions: for the heartbeats, which would else make
  /// this process read all anew (epoch()).
  template <typename Use>
  std::invoke_result_t<Use, storage::JobStore&> with_job_leases(Use&& use) {
    const std::unique_lock lock(session_mutex_, patience_);
    if (!lock) return busy();
    if (const auto in_place = map_database_->check_in_place(); !in_place) return in_place.error();
    return std::forward<Use>(use)(job_leases_);
  }

  [[nodiscard]] Result<std::vector<storage::TokenRecord>> tokens();

  /// Of what the database holds.
  [[nodiscard]] Result<std::uint64_t> used_bytes();

  /// Grows whenever the file was changed by anything but the sessions of this process: by this
  /// process' maps or by another process. What was read before is then to be read again.
  [[nodiscard]] Result<std::uint64_t> epoch();
  /// The same for what concerns one session: it also grows when another process of a PostgreSQL
  /// database changed that session.
  [[nodiscard]] Result<std::uint64_t> epoch(std::string_view session);

  /// Whether the file can be read and written, its pages are sound, and its file system has
  /// `min_free_bytes` left.
  [[nodiscard]] Result<void> probe(std::uint64_t min_free_bytes);

 private:
  StoreAccess(std::shared_ptr<storage::Database> map_database,
              std::shared_ptr<storage::Database> session_database,
              std::chrono::milliseconds patience, std::size_t kept_revisions);

  [[nodiscard]] static Error busy();
  /// On the locked connection for sessions.
  [[nodiscard]] Result<std::uint64_t> read_epoch();

  std::mutex map_mutex_;
  std::shared_ptr<storage::Database> map_database_;
  storage::MapStore maps_;
  storage::SessionStore session_list_;
  storage::JobStore jobs_;

  const std::chrono::milliseconds patience_;  ///< For other calls about sessions.
  std::timed_mutex session_mutex_;
  std::shared_ptr<storage::Database> session_database_;
  storage::SessionStore sessions_;
  storage::MapStore map_entries_;
  storage::TokenStore tokens_;
  storage::JobStore job_leases_;
  std::int64_t data_version_ = -1;
  std::uint64_t epoch_ = 0;
  OncePerSecond write_check_;

  PageCheck page_check_;
};

}  // namespace cornerfix::server

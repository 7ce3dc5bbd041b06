/// \file  The sessions in memory, by id.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "server/live_session.hpp"

namespace cornerfix::server {

/// Sessions by status, in the order of `Status`.
using SessionCounts = std::array<std::size_t, 4>;

/// A session is in use as long as somebody else than the table holds it. Any threads may call.
class SessionTable {
 public:
  using Clock = std::chrono::steady_clock;

  /// The session; null when it is not in memory.
  [[nodiscard]] std::shared_ptr<LiveSession> find(const std::string& id);
  /// The session, made when it is not there yet.
  [[nodiscard]] std::shared_ptr<LiveSession> take(const std::string& id, Clock::time_point now);
  void forget(const std::string& id);

  /// Forgets those that are not in use and were not taken for `idle_time`. Looks now and then only;
  /// returns whether it did.
  bool forget_idle(Clock::time_point now, std::chrono::minutes idle_time);

  /// When localizers use more than `max_bytes`, forgets those that were not taken for longest. A
  /// tenth of the room is then free, so that not every batch has to look.
  void forget_least_used(std::size_t max_bytes);

  /// Until `has_room`, releases the localizers of sessions that are not in use. Those of localized
  /// robots come last, and of each kind the least recently used first. A search that goes on with
  /// the next scan keeps its localizer: it would begin anew.
  void release_localizers(const std::function<bool()>& has_room);

  [[nodiscard]] SessionCounts count_by_status();

 private:
  std::atomic<std::size_t> live_bytes_ = 0;  ///< Of sessions with a localizer, about.
  std::mutex mutex_;
  std::unordered_map<std::string, std::shared_ptr<LiveSession>> sessions_;
  Clock::time_point next_sweep_{};
};

}  // namespace cornerfix::server

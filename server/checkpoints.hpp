/// \file  Stores sessions some time after their batches were acknowledged.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "server/live_session.hpp"
#include "server/store_access.hpp"

namespace cornerfix::server {

/// A session is stored half an interval after its first batch that the store does not have, so that
/// it is stored when the interval ends. Many sessions share a transaction. A session that cannot be
/// stored is tried again each second. Any threads may call.
class Checkpoints {
 public:
  using Clock = std::chrono::steady_clock;
  using SessionPtr = std::shared_ptr<LiveSession>;

  Checkpoints(std::shared_ptr<StoreAccess> stores, std::chrono::milliseconds interval);
  ~Checkpoints();  ///< Stores what can be stored.
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;

  /// Notes that the session has a batch which the store does not have. It is held by the caller,
  /// and stays in memory until it is stored.
  void add(LiveSession& session);

  /// Whether a session, which the caller holds, has such a batch for longer than the interval.
  [[nodiscard]] bool is_overdue(const LiveSession& session) const;

  /// Stores all of them now, but for those that are within a batch. Returns how many could not be.
  [[nodiscard]] std::size_t store_all();

 private:
  void run();
  /// Stores some of those that are due by `now`.
  void store_due(Clock::time_point now);
  /// Those that are due by `now`, taken from the queue: some, so that a transaction is short.
  [[nodiscard]] std::vector<SessionPtr> take_due(Clock::time_point now);
  /// Returns how many could not be stored; they are in the queue again.
  std::size_t store(std::vector<SessionPtr> group);

  const std::shared_ptr<StoreAccess> stores_;
  const std::chrono::milliseconds interval_;
  /// Held while sessions that were taken from the queue are stored. Locked before `mutex_`.
  std::mutex storing_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::multimap<Clock::time_point, SessionPtr> queue_;  ///< By when they are due.
  bool is_closing_ = false;
  std::thread thread_;
};

}  // namespace cornerfix::server

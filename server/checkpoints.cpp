#include "server/checkpoints.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <deque>
#include <utility>

namespace cornerfix::server {
namespace {

using storage::SessionChange;
using storage::SessionStore;

constexpr std::size_t kMaxGroup = 64;
constexpr std::chrono::milliseconds kBusyDelay{5};
constexpr std::chrono::seconds kRetryDelay{1};

/// The sessions of one transaction, held while it is written.
struct CheckpointGroup {
  std::vector<std::unique_lock<std::mutex>> locks{};
  std::vector<LiveSession*> sessions{};
  std::deque<LocalizerState> states{};
  std::vector<SessionChange> changes{};

  void add(LiveSession& session, std::unique_lock<std::mutex> lock) {
    locks.push_back(std::move(lock));
    sessions.push_back(&session);
    states.push_back(session.state());
    changes.push_back(session.change(states.back()));
  }

  /// Notes what came of a change; false when it has to be tried again.
  bool end(std::size_t number, const Result<void>& result) {
    LiveSession& session = *sessions[number];
    if (result) {
      session.note_stored(states[number]);
      return true;
    }
    const ErrorCode code = result.error().code;
    if (code == ErrorCode::kConflict || code == ErrorCode::kNotFound) {
      session.discard();  // Another server has taken it over, or it was removed.
      return true;
    }
    spdlog::warn("session {} is not stored yet: {}", session.record.id, result.error().message);
    return false;
  }
};

}  // namespace

Checkpoints::Checkpoints(std::shared_ptr<StoreAccess> stores, std::chrono::milliseconds interval)
    : stores_(std::move(stores)), interval_(interval), thread_([this] { run(); }) {}

Checkpoints::~Checkpoints() {
  {
    const std::lock_guard lock(mutex_);
    is_closing_ = true;
  }
  changed_.notify_all();
  thread_.join();
  (void)store_all();
}

void Checkpoints::add(LiveSession& session) {
  if (session.unstored_since) return;
  const Clock::time_point now = Clock::now();
  session.unstored_since = now;
  const std::lock_guard lock(mutex_);
  queue_.emplace(now + interval_ / 2, session.shared_from_this());
  changed_.notify_all();
}

bool Checkpoints::is_overdue(const LiveSession& session) const {
  return session.unstored_since && Clock::now() - *session.unstored_since >= interval_;
}

std::size_t Checkpoints::store_all() {
  const std::lock_guard storing(storing_);
  std::size_t failed = 0;
  std::vector<SessionPtr> all;
  {
    const std::lock_guard lock(mutex_);
    for (auto& [due, session] : std::exchange(queue_, {})) all.push_back(std::move(session));
  }
  for (std::size_t begin = 0; begin < all.size(); begin += kMaxGroup) {
    const std::size_t end = std::min(all.size(), begin + kMaxGroup);
    const auto at = [&](std::size_t i) { return all.begin() + static_cast<std::ptrdiff_t>(i); };
    failed += store({at(begin), at(end)});
  }
  return failed;
}

void Checkpoints::run() {
  std::unique_lock lock(mutex_);
  while (!is_closing_) {
    const Clock::time_point now = Clock::now();
    if (queue_.empty()) {
      changed_.wait(lock);
    } else if (const Clock::time_point due = queue_.begin()->first; due > now) {
      changed_.wait_until(lock, due);
    } else {
      lock.unlock();
      store_due(now);
      lock.lock();
    }
  }
}

void Checkpoints::store_due(Clock::time_point now) {
  const std::lock_guard storing(storing_);
  std::unique_lock lock(mutex_);
  const std::vector<SessionPtr> group = take_due(now);
  lock.unlock();
  (void)store(group);
}

std::vector<Checkpoints::SessionPtr> Checkpoints::take_due(Clock::time_point now) {
  std::vector<SessionPtr> group;
  while (!queue_.empty() && queue_.begin()->first <= now && group.size() < kMaxGroup) {
    group.push_back(std::move(queue_.begin()->second));
    queue_.erase(queue_.begin());
  }
  return group;
}

std::size_t Checkpoints::store(std::vector<SessionPtr> group) {
  // One that was stored meanwhile by its own thread may be in the queue twice.
  std::ranges::sort(group);
  group.erase(std::unique(group.begin(), group.end()), group.end());
  std::vector<std::pair<Clock::duration, SessionPtr>> again;
  CheckpointGroup held;
  for (const SessionPtr& session : group) {
    // Never waits for a session while it holds others.
    std::unique_lock lock(session->mutex, std::try_to_lock);
    if (!lock) {
      again.emplace_back(kBusyDelay, session);
    } else if (session->unstored_since && session->is_whole) {
      held.add(*session, std::move(lock));
    }
  }
  auto written =
      stores_->with_sessions([&](SessionStore& sessions) -> Result<std::vector<Result<void>>> {
        return sessions.update(held.changes);
      });
  for (std::size_t i = 0; i < held.sessions.size(); ++i) {
    const Result<void> result = written ? (*written)[i] : written.error();
    if (!held.end(i, result)) again.emplace_back(kRetryDelay, held.sessions[i]->shared_from_this());
  }
  const Clock::time_point now = Clock::now();
  const std::lock_guard lock(mutex_);
  for (auto& [delay, session] : again) queue_.emplace(now + delay, std::move(session));
  return again.size();
}

}  // namespace cornerfix::server

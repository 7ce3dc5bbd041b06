#include "server/session_table.hpp"

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

namespace cornerfix::server {
namespace {

constexpr std::chrono::seconds kSweepInterval{30};

}  // namespace

std::shared_ptr<LiveSession> SessionTable::find(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(id);
  return found == sessions_.end() ? nullptr : found->second;
}

std::shared_ptr<LiveSession> SessionTable::take(const std::string& id, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<LiveSession>& entry = sessions_[id];
  if (!entry) entry = std::make_shared<LiveSession>(live_bytes_);
  entry->last_used = now;
  return entry;
}

void SessionTable::forget(const std::string& id) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(id);
}

bool SessionTable::forget_idle(Clock::time_point now, std::chrono::minutes idle_time) {
  const std::lock_guard lock(mutex_);
  if (now < next_sweep_) return false;
  next_sweep_ = now + kSweepInterval;
  std::erase_if(sessions_, [&](const auto& entry) {
    const auto& session = entry.second;
    return session.use_count() == 1 && now - session->last_used > idle_time;
  });
  return true;
}

void SessionTable::forget_least_used(std::size_t max_bytes) {
  if (live_bytes_ <= max_bytes) return;
  const std::lock_guard lock(mutex_);
  std::vector<std::pair<Clock::time_point, std::string>> parkable;
  for (const auto& [id, session] : sessions_) {
    if (session->bytes > 0 && session.use_count() == 1)
      parkable.emplace_back(session->last_used, id);
  }
  std::ranges::sort(parkable);
  const std::size_t wanted = max_bytes - max_bytes / 10;
  for (const auto& [last_used, id] : parkable) {
    if (live_bytes_ <= wanted) return;
    sessions_.erase(id);
  }
}

void SessionTable::release_localizers(const std::function<bool()>& has_room) {
  if (has_room()) return;
  const std::lock_guard lock(mutex_);
  std::vector<std::tuple<bool, Clock::time_point, LiveSession*>> idle;
  for (const auto& [id, session] : sessions_) {
    if (session.use_count() > 1) continue;
    // Nobody waits for it: who takes a session needs the table's mutex first.
    const std::lock_guard session_lock(session->mutex);
    if (session->can_release_localizer())
      idle.emplace_back(session->is_tracking(), session->last_used, session.get());
  }
  std::ranges::sort(idle);
  for (const auto& [is_tracking, last_used, session] : idle) {
    const std::lock_guard session_lock(session->mutex);
    session->release_localizer();
    if (has_room()) return;
  }
}

SessionCounts SessionTable::count_by_status() {
  SessionCounts counts{};
  const std::lock_guard lock(mutex_);
  for (const auto& [id, session] : sessions_) {
    ++counts[static_cast<std::size_t>(session->status.load())];
  }
  return counts;
}

}  // namespace cornerfix::server

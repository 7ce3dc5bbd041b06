#include "server/event_hub.hpp"

#include <utility>

namespace cornerfix::server {

std::optional<std::string> EventSubscription::next(std::chrono::milliseconds heartbeat) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, heartbeat, [this] { return closed_ || !queue_.empty(); });
  if (!queue_.empty()) {
    std::string event = std::move(queue_.front());
    queue_.pop_front();
    return event;
  }
  if (closed_) return std::nullopt;
  return ": still here\n\n";
}

bool EventSubscription::push(std::string event) {
  const std::lock_guard lock(mutex_);
  if (queue_.size() >= kMaxQueued) closed_ = true;
  if (!closed_) queue_.push_back(std::move(event));
  changed_.notify_one();
  return !closed_;
}

void EventSubscription::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_one();
}

std::shared_ptr<EventSubscription> EventHub::subscribe(const std::string& session) {
  const std::lock_guard lock(mutex_);
  remove_expired();
  if (closed_ || subscriptions_.size() >= max_clients_) return nullptr;
  auto subscription = std::make_shared<EventSubscription>();
  subscriptions_.emplace(session, subscription);
  return subscription;
}

std::size_t EventHub::count() {
  const std::lock_guard lock(mutex_);
  remove_expired();
  return subscriptions_.size();
}

bool EventHub::is_watched(const std::string& session) {
  const std::lock_guard lock(mutex_);
  remove_expired();
  return subscriptions_.contains(session);
}

void EventHub::publish(const std::string& session, const std::string& event) {
  const std::lock_guard lock(mutex_);
  auto [begin, end] = subscriptions_.equal_range(session);
  while (begin != end) {
    const auto subscription = begin->second.lock();
    const bool keeps_up = subscription && subscription->push(event);
    begin = keeps_up ? std::next(begin) : subscriptions_.erase(begin);
  }
}

void EventHub::end(const std::string& session) {
  const std::lock_guard lock(mutex_);
  const auto [begin, end] = subscriptions_.equal_range(session);
  for (auto entry = begin; entry != end; ++entry) {
    if (const auto subscription = entry->second.lock()) subscription->close();
  }
  subscriptions_.erase(begin, end);
}

void EventHub::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  for (const auto& [session, weak] : subscriptions_) {
    if (const auto subscription = weak.lock()) subscription->close();
  }
  subscriptions_.clear();
}

void EventHub::remove_expired() {
  std::erase_if(subscriptions_, [](const auto& entry) { return entry.second.expired(); });
}

std::string format_answer_event(std::uint64_t sequence, std::string_view data) {
  std::string event = "event: answer\nid: " + std::to_string(sequence) + "\ndata: ";
  event += data;
  event += "\n\n";
  return event;
}

}  // namespace cornerfix::server

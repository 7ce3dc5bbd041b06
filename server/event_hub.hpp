/// \file  Answers handed to those who watch a session, as Server-Sent Events.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace cornerfix::server {

/// One watcher's queue. A watcher that does not keep up is dropped: its stream ends, and it may
/// connect again. Any threads may call.
class EventSubscription {
 public:
  /// Waits for the next piece of the stream: events, or a comment after `heartbeat` without any.
  /// Nothing when the stream is over.
  [[nodiscard]] std::optional<std::string> next(std::chrono::milliseconds heartbeat);

  /// False when it is over or its queue was full, which ends it.
  bool push(std::string event);
  void close();

 private:
  static constexpr std::size_t kMaxQueued = 64;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> queue_;
  bool closed_ = false;
};

/// Who watches what. Any threads may call.
class EventHub {
 public:
  explicit EventHub(std::size_t max_clients) : max_clients_(max_clients) {}

  /// Nothing when there are too many watchers, or after close(). The subscription ends with its
  /// last pointer.
  [[nodiscard]] std::shared_ptr<EventSubscription> subscribe(const std::string& session);

  /// Watchers of all sessions.
  [[nodiscard]] std::size_t count();
  [[nodiscard]] bool is_watched(const std::string& session);
  void publish(const std::string& session, const std::string& event);
  /// Ends the streams of a session that is no more.
  void end(const std::string& session);
  /// Ends all streams: the server is going down.
  void close();

 private:
  void remove_expired();

  const std::size_t max_clients_;
  std::mutex mutex_;
  std::multimap<std::string, std::weak_ptr<EventSubscription>> subscriptions_;
  bool closed_ = false;
};

/// `data` (one line) as an event named "answer".
[[nodiscard]] std::string format_answer_event(std::uint64_t sequence, std::string_view data);

}  // namespace cornerfix::server

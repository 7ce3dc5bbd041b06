/// \file  Signals that stop a server, and the time in which its process ends then.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace cornerfix::server {

/// What signals do. Called by a thread of their own.
struct SignalHandlers {
  std::function<void()> reload;   ///< SIGHUP.
  std::function<void()> drain;    ///< SIGTERM or SIGINT.
  std::function<void()> give_up;  ///< The process is left: it did not end in time.
};

/// SIGTERM, SIGINT and SIGHUP of this process. Every thread made after this one leaves them alone.
class StopSignals {
 public:
  StopSignals();

  /// From SIGTERM or SIGINT on the process has `stop_time` to end(). Then it ends with exit code 0,
  /// also when some of its threads do not.
  void handle(SignalHandlers handlers, std::chrono::seconds stop_time);
  /// To be called when nothing is left that may take time.
  void end();

 private:
  std::thread thread_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool has_ended_ = false;
};

/// Calls to a server, one at a time, until its destruction begins.
template <typename Server>
class LastCalls {
 public:
  explicit LastCalls(Server& server) : server_(&server) {}
  template <typename Call>
  void with_server(Call call) {
    const std::lock_guard lock(mutex_);
    if (server_ != nullptr) call(*server_);
  }
  /// Waits for the call under way; there are no later ones.
  void end() {
    const std::lock_guard lock(mutex_);
    server_ = nullptr;
  }

 private:
  std::mutex mutex_;
  Server* server_;
};

/// Runs a server until it is drained, stores its sessions and destroys it. All of this has
/// `stop_time` from the signal on, because a server may have threads that end much later. Only the
/// storing of sessions may take longer: what it has begun is finished.
/// \return What run() returned.
template <typename Server>
[[nodiscard]] bool run_until_stopped(std::unique_ptr<Server> server, StopSignals& signals,
                                     std::chrono::seconds stop_time,
                                     const std::function<void(Server&)>& reload,
                                     const std::function<void(Server&)>& store_sessions,
                                     const std::function<void()>& on_ready) {
  LastCalls<Server> calls(*server);
  signals.handle({.reload = [&] { calls.with_server(reload); },
                  .drain = [&] { calls.with_server([](Server& live) { live.drain(); }); },
                  .give_up = [&] { calls.with_server(store_sessions); }},
                 stop_time);
  on_ready();
  const bool was_drained = server->run();
  calls.with_server(store_sessions);
  calls.end();
  server.reset();
  signals.end();
  return was_drained;
}

}  // namespace cornerfix::server

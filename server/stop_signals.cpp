#include "server/stop_signals.hpp"

#include <malloc.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <cstdlib>

namespace cornerfix::server {
namespace {

/// How often freed memory goes back to the system [s]. A session that searches needs several times
/// what it needs later, in pieces between those that others keep.
constexpr int kTrimInterval = 10;

sigset_t handled_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  return signals;
}

/// The next signal. Meanwhile, memory that is free goes back to the system.
int next_signal() {
  const sigset_t signals = handled_signals();
  const timespec interval{.tv_sec = kTrimInterval, .tv_nsec = 0};
  for (;;) {
    const int signal = sigtimedwait(&signals, nullptr, &interval);
    if (signal > 0) return signal;
    malloc_trim(0);
  }
}

}  // namespace

StopSignals::StopSignals() {
  const sigset_t signals = handled_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

void StopSignals::handle(SignalHandlers handlers, std::chrono::seconds stop_time) {
  thread_ = std::thread([this, handlers = std::move(handlers), stop_time] {
    while (next_signal() == SIGHUP) handlers.reload();
    handlers.drain();
    std::unique_lock lock(mutex_);
    if (ended_.wait_for(lock, stop_time, [this] { return has_ended_; })) return;
    spdlog::warn("some work does not end in time; leaving it");
    handlers.give_up();
    spdlog::default_logger()->flush();  // Others may still log: it stays.
    std::_Exit(EXIT_SUCCESS);
  });
}

void StopSignals::end() {
  {
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
  }
  ended_.notify_all();
  // The thread waits for just this signal, which is blocked everywhere else.
  pthread_kill(thread_.native_handle(), SIGTERM);  // NOLINT(bugprone-bad-signal-to-kill-thread)
  thread_.join();
}

}  // namespace cornerfix::server

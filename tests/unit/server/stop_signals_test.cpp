#include "server/stop_signals.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <utility>

namespace cornerfix::server {
namespace {

/// Stops its own process, and has a thread that never ends.
class StuckServer {
 public:
  ~StuckServer() { std::promise<void>().get_future().wait(); }
  bool run() {
    kill(getpid(), SIGTERM);
    drained_.get_future().wait();
    return true;
  }
  void drain() { drained_.set_value(); }

 private:
  std::promise<void> drained_;
};

/// The same without such a thread.
class QuickServer {
 public:
  explicit QuickServer(std::string& log) : log_(log) {}
  ~QuickServer() { log_ += " destroyed"; }
  bool run() {
    kill(getpid(), SIGTERM);
    drained_.get_future().wait();
    log_ += " drained";
    return true;
  }
  void drain() { drained_.set_value(); }
  std::string& log() { return log_; }

 private:
  std::string& log_;
  std::promise<void> drained_;
};

template <typename Server>
bool run(std::unique_ptr<Server> server, std::chrono::seconds stop_time,
         const std::function<void(Server&)>& store_sessions) {
  StopSignals signals;
  return run_until_stopped<Server>(std::move(server), signals, stop_time, {}, store_sessions,
                                   [] {});
}

TEST(StopSignalsDeathTest, EndTheProcessInTimeAlthoughAThreadOfTheServerDoesNotEnd) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT((void)run<StuckServer>(std::make_unique<StuckServer>(), std::chrono::seconds(0),
                                     [](StuckServer&) {}),
              ::testing::ExitedWithCode(EXIT_SUCCESS), "");
}

TEST(StopSignalsDeathTest, DrainTheServerAndStoreItsSessionsBeforeItIsDestroyed) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto serve = [] {
    std::string log;
    const bool was_drained =
        run<QuickServer>(std::make_unique<QuickServer>(log), std::chrono::hours(1),
                         [](QuickServer& server) { server.log() += " stored"; });
    std::exit(was_drained && log == " drained stored destroyed" ? 7 : 8);
  };
  EXPECT_EXIT(serve(), ::testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace cornerfix::server

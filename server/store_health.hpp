/// \file  Whether the database can serve and store, found out now and then.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <mutex>

#include <cornerfix/result.hpp>

#include "storage/database.hpp"

namespace cornerfix::server {

/// A look at all pages takes about a second per gigabyte. It runs beside the requests, at most a
/// twentieth of the time, and its last result stands until the next. Any threads may call.
class PageCheck {
 public:
  explicit PageCheck(std::shared_ptr<const storage::Database> database);
  ~PageCheck();
  PageCheck(const PageCheck&) = delete;
  PageCheck& operator=(const PageCheck&) = delete;

  /// The last result, after a new look when one is due and does not take long.
  [[nodiscard]] Result<void> result();

 private:
  using Clock = std::chrono::steady_clock;
  struct Look {
    Result<void> result;
    Clock::duration duration{};
  };

  void take_when_done(std::chrono::milliseconds patience);

  std::shared_ptr<const storage::Database> database_;
  std::atomic<bool> is_cancelled_ = false;
  std::mutex mutex_;
  std::future<Look> look_;
  Clock::time_point next_{};
  Result<void> last_;
};

/// Remembers the result of a test for a second, since anybody may ask whether the server is ready.
class OncePerSecond {
 public:
  using Test = std::function<Result<void>()>;

  [[nodiscard]] Result<void> result(const Test& test);

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point next_{};
  Result<void> last_;
};

}  // namespace cornerfix::server

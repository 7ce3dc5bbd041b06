/// \file  Independent pieces of work on several threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace cornerfix::evaluation {

/// Called with what is done and with all, from any thread, one at a time; may be empty.
using ShareDone = std::function<void(std::size_t, std::size_t)>;

/// Calls `work` with 0 to `count` - 1, each once, on `threads` threads; returns when all is done.
inline void in_parallel(std::size_t count, std::size_t threads,
                        const std::function<void(std::size_t)>& work, const ShareDone& progress) {
  std::atomic<std::size_t> next{0};
  std::mutex progress_mutex;
  std::size_t done = 0;
  const auto work_on = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      work(i);
      const std::lock_guard lock(progress_mutex);
      if (progress) progress(++done, count);
    }
  };
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < threads; ++i) others.emplace_back(work_on);
  work_on();
  for (std::thread& thread : others) thread.join();
}

}  // namespace cornerfix::evaluation

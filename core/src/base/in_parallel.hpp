/// \file  The same work for many independent things, on all cores.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace cornerfix {

/// Calls `work(i)` once for each i below `count`, in any order and several at a time, and returns
/// when all is done. After an exception no more is begun; the first one reaches the caller.
template <typename Work>
void for_each_in_parallel(std::size_t count, const Work& work) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto take_turns = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) work(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> helpers;
    const std::size_t threads = std::min<std::size_t>(count, std::thread::hardware_concurrency());
    try {
      for (std::size_t i = 1; i < threads; ++i) helpers.emplace_back(take_turns);
    } catch (const std::system_error&) {
      // No more threads can be started: the existing ones do the work.
    }
    take_turns();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace cornerfix

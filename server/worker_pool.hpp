/// \file  Threads that answer requests, made as they are needed.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace cornerfix::server {

/// A job answers one request. When all threads are busy, a job that has waited for `queue_timeout`
/// runs on one of a few spare threads, where is_shedding() is true: it answers "busy". Any thread
/// may call.
class WorkerPool {
 public:
  WorkerPool(std::size_t max_threads, std::chrono::milliseconds queue_timeout);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  void enqueue(std::function<void()> job);

  /// Runs what is queued, then ends the threads. No job may be enqueued from then on.
  void shutdown();

  struct Load {
    std::size_t threads = 0;  ///< Made so far, without the spare ones.
    std::size_t busy = 0;
  };
  [[nodiscard]] Load load();

  /// Whether the calling thread is there to turn requests away.
  [[nodiscard]] static bool is_shedding();

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    std::function<void()> run;
    Clock::time_point due;  ///< From then on a spare thread takes it.
  };

  void work();
  void shed();
  /// Whether a job waits that no thread is free for. With the mutex held.
  [[nodiscard]] bool is_overfull() const { return !jobs_.empty() && busy_ == max_threads_; }

  const std::size_t max_threads_;
  const std::chrono::milliseconds queue_timeout_;
  std::mutex mutex_;
  std::condition_variable job_added_;  ///< Workers wait for it,
  std::condition_variable overfull_;   ///< and spare threads for this.
  std::deque<Job> jobs_;
  std::size_t busy_ = 0;  ///< Workers with a job.
  bool closing_ = false;
  std::vector<std::thread> workers_;
  std::vector<std::thread> spare_;
};

}  // namespace cornerfix::server

#include "server/worker_pool.hpp"

#include <utility>

namespace cornerfix::server {
namespace {

constexpr std::size_t kSpareThreads = 2;

bool& shedding() {
  thread_local bool value = false;
  return value;
}

}  // namespace

WorkerPool::WorkerPool(std::size_t max_threads, std::chrono::milliseconds queue_timeout)
    : max_threads_(max_threads), queue_timeout_(queue_timeout) {
  for (std::size_t i = 0; i < kSpareThreads; ++i) spare_.emplace_back([this] { shed(); });
}

WorkerPool::~WorkerPool() { shutdown(); }

void WorkerPool::enqueue(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back({std::move(job), Clock::now() + queue_timeout_});
    const std::size_t free = workers_.size() - busy_;
    if (jobs_.size() > free && workers_.size() < max_threads_) {
      workers_.emplace_back([this] { work(); });
    }
    if (is_overfull()) overfull_.notify_one();
  }
  // One worker: to wake all of them for each request costs more than many a request.
  job_added_.notify_one();
}

void WorkerPool::shutdown() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  job_added_.notify_all();
  overfull_.notify_all();
  for (auto* threads : {&workers_, &spare_}) {
    for (std::thread& thread : *threads) thread.join();
    threads->clear();
  }
}

WorkerPool::Load WorkerPool::load() {
  const std::lock_guard lock(mutex_);
  return {workers_.size(), busy_};
}

bool WorkerPool::is_shedding() { return shedding(); }

void WorkerPool::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    job_added_.wait(lock, [this] { return closing_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    const auto job = std::move(jobs_.front().run);
    jobs_.pop_front();
    ++busy_;
    if (is_overfull()) overfull_.notify_one();  // A spare thread watches from now on.
    lock.unlock();
    job();
    lock.lock();
    --busy_;
  }
}

void WorkerPool::shed() {
  shedding() = true;
  std::unique_lock lock(mutex_);
  for (;;) {
    overfull_.wait(lock, [this] { return closing_ || is_overfull(); });
    if (closing_) return;
    const Clock::time_point due = jobs_.front().due;
    if (Clock::now() < due) {
      overfull_.wait_until(lock, due);
      continue;
    }
    overfull_.notify_one();  // The other spare thread may be needed, too.
    const auto job = std::move(jobs_.front().run);
    jobs_.pop_front();
    lock.unlock();
    job();
    lock.lock();
  }
}

}  // namespace cornerfix::server

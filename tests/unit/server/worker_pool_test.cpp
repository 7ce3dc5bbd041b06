#include "server/worker_pool.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <future>

namespace cornerfix::server {
namespace {

using namespace std::chrono_literals;

TEST(WorkerPool, RunsJobsSideBySideUpToItsSize) {
  WorkerPool pool(2, 1h);
  std::promise<void> first_runs;
  std::promise<void> second_runs;
  pool.enqueue([&] {
    first_runs.set_value();
    second_runs.get_future().wait();
  });
  pool.enqueue([&] {
    first_runs.get_future().wait();
    second_runs.set_value();
  });
  pool.shutdown();
}

TEST(WorkerPool, RunsWhatIsQueuedBeforeItEnds) {
  std::atomic<int> runs = 0;
  WorkerPool pool(1, 1h);
  for (int i = 0; i < 20; ++i) {
    pool.enqueue([&] { ++runs; });
  }
  pool.shutdown();
  EXPECT_EQ(runs, 20);
}

TEST(WorkerPool, ShedsAJobThatWaitsTooLong) {
  WorkerPool pool(1, 1ms);
  std::promise<void> release;
  std::promise<bool> was_shed;
  pool.enqueue([released = release.get_future().share()] { released.wait(); });
  pool.enqueue([&] { was_shed.set_value(WorkerPool::is_shedding()); });
  EXPECT_TRUE(was_shed.get_future().get());
  release.set_value();
  pool.shutdown();
}

TEST(WorkerPool, DoesNotShedWhatAThreadIsFreeForHoweverLongThatTakes) {
  WorkerPool pool(1, 0ms);
  std::promise<bool> was_shed;
  pool.enqueue([&] { was_shed.set_value(WorkerPool::is_shedding()); });
  EXPECT_FALSE(was_shed.get_future().get());
}

}  // namespace
}  // namespace cornerfix::server

#include "server/group_commit.hpp"

#include <gtest/gtest.h>

#include <future>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace cornerfix::server {
namespace {

/// Writes one group at a time, when the test lets it.
class SlowStore {
 public:
  std::vector<Result<void>> write(std::span<const storage::SessionChange> changes) {
    std::unique_lock lock(mutex_);
    groups_.push_back(changes.size());
    changed_.notify_all();
    changed_.wait(lock, [&] { return allowed_ >= groups_.size(); });
    std::vector<Result<void>> results;
    for (const storage::SessionChange& change : changes) {
      results.push_back(change.id == "wrong" ? Result<void>(Error{ErrorCode::kConflict, "", ""})
                                             : Result<void>());
    }
    return results;
  }

  void wait_for_groups(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return groups_.size() >= count; });
  }

  void allow(std::size_t groups) {
    const std::lock_guard lock(mutex_);
    allowed_ = groups;
    changed_.notify_all();
  }

  std::vector<std::size_t> groups() {
    const std::lock_guard lock(mutex_);
    return groups_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::size_t> groups_;
  std::size_t allowed_ = 0;
};

TEST(GroupCommitTest, WritesAChangeAtOnceWhenNothingElseIsWritten) {
  SlowStore store;
  store.allow(2);
  GroupCommit commit([&](auto changes) { return store.write(changes); });
  EXPECT_TRUE(commit.store({"a", {}}));
  EXPECT_EQ(commit.store({"wrong", {}}).error().code, ErrorCode::kConflict);
  EXPECT_EQ(store.groups(), (std::vector<std::size_t>{1, 1}));
}

TEST(GroupCommitTest, JoinsWhatCameWhileAnotherChangeWasWritten) {
  SlowStore store;
  GroupCommit commit([&](auto changes) { return store.write(changes); });
  const auto start = [&](const char* id) {
    return std::async(std::launch::async, [&commit, id] { return commit.store({id, {}}); });
  };
  auto first = start("a");
  store.wait_for_groups(1);
  std::vector<std::future<Result<void>>> others;
  for (const char* id : {"b", "wrong", "c"}) others.push_back(start(id));
  while (commit.waiting() < 3) std::this_thread::yield();
  store.allow(2);
  EXPECT_TRUE(first.get());
  EXPECT_TRUE(others[0].get());
  EXPECT_FALSE(others[1].get());
  EXPECT_TRUE(others[2].get());
  EXPECT_EQ(store.groups(), (std::vector<std::size_t>{1, 3}));
}

// With ThreadSanitizer: no thread reads a result that another one is writing.
TEST(GroupCommitTest, GivesEachOfManyThreadsItsOwnResult) {
  GroupCommit commit([](std::span<const storage::SessionChange> changes) {
    std::this_thread::yield();  // Others wait meanwhile, and are woken by the group before.
    std::vector<Result<void>> results;
    for (const storage::SessionChange& change : changes) {
      results.push_back(change.id.empty() ? Result<void>()
                                          : Result<void>(Error{ErrorCode::kConflict, "", ""}));
    }
    return results;
  });
  constexpr int kRounds = 2000;
  const auto count_stored = [&commit](const char* id) {
    int stored = 0;
    for (int i = 0; i < kRounds; ++i) stored += commit.store({id, {}}) ? 1 : 0;
    return stored;
  };
  std::vector<std::future<int>> threads;
  for (int i = 0; i < 8; ++i) {
    threads.push_back(std::async(std::launch::async, count_stored, i % 2 == 0 ? "" : "wrong"));
  }
  for (std::size_t i = 0; i < threads.size(); ++i) {
    EXPECT_EQ(threads[i].get(), i % 2 == 0 ? kRounds : 0);
  }
}

TEST(GroupCommitTest, GoesOnAfterAnException) {
  bool throws = true;
  GroupCommit commit([&](auto changes) {
    if (throws) throw std::runtime_error("no memory");
    return std::vector<Result<void>>(changes.size());
  });
  EXPECT_EQ(commit.store({"a", {}}).error().message, "no memory");
  throws = false;
  EXPECT_TRUE(commit.store({"a", {}}));
}

}  // namespace
}  // namespace cornerfix::server

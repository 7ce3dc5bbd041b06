#include "server/checkpoints.hpp"

#include <SQLiteCpp/Database.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "unit/server/localization_service_fixture.hpp"

namespace cornerfix::server {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr milliseconds kNever = std::chrono::hours(1);
constexpr milliseconds kSoon{40};
constexpr std::chrono::seconds kDeadline{60};

class CheckpointsTest : public LocalizationServiceTest {
 protected:
  Process with_interval(milliseconds interval) const {
    return Process(file(), {}, {.checkpoint_interval = interval});
  }

  std::uint64_t stored(const std::string& id) {
    return process_.stores
        ->with_sessions([&](storage::SessionStore& sessions) { return sessions.find(id); })
        .value()
        ->expected_sequence;
  }
};

TEST_F(CheckpointsTest, AnswersBeforeASessionIsStored) {
  Process process = with_interval(kNever);
  const std::string id = create(process);
  answer(process, id, batch(0));
  EXPECT_EQ(process.localization.store_all(), 0U);
  for (std::uint64_t i = 1; i < 3; ++i) answer(process, id, batch(i));
  EXPECT_EQ(stored(id), 1U);
  EXPECT_EQ(process.localization.find(id)->expected_sequence, 3U);
}

TEST_F(CheckpointsTest, StoresASessionWithinTheInterval) {
  Process process = with_interval(kSoon);
  const std::string id = create(process);
  for (std::uint64_t i = 0; i < 3; ++i) answer(process, id, batch(i));
  const auto deadline = Clock::now() + kDeadline;
  while (stored(id) < 3 && Clock::now() < deadline) std::this_thread::yield();
  EXPECT_EQ(stored(id), 3U);
}

TEST_F(CheckpointsTest, StoresAllWhenTheServerEnds) {
  std::string first;
  std::string second;
  {
    Process process = with_interval(kNever);
    first = create(process);
    second = create(process);
    for (std::uint64_t i = 0; i < 2; ++i) answer(process, first, batch(i));
    answer(process, second, batch(0));
    EXPECT_EQ(process.localization.store_all(), 0U);
    EXPECT_EQ(stored(first), 2U);
    answer(process, first, batch(2));
  }
  EXPECT_EQ(stored(first), 3U);
  EXPECT_EQ(stored(second), 1U);
}

TEST_F(CheckpointsTest, GoesOnFromTheStoredBatchAfterACrash) {
  Process process = with_interval(kNever);
  const std::string id = create(process);
  const std::string alone = create(process_);
  for (std::uint64_t i = 0; i < 6; ++i) {
    answer(process, id, batch(i));
    if (i == 3) {
      EXPECT_EQ(process.localization.store_all(), 0U);
    }
  }
  for (std::uint64_t i = 0; i < 6; ++i) answer(process_, alone, batch(i));
  Process next(file());  // The first one is as good as dead.
  const auto refused = next.localization.post_scans(id, batch(6));
  EXPECT_EQ(refused->expected_sequence, 4U);
  EXPECT_EQ(refused->last_stamp, batch(3).scans.back().scan.stamp);
  for (std::uint64_t i = 4; i < 7; ++i) answer(next, id, batch(i));
  answer(process_, alone, batch(6));
  const std::string expected = answer(process_, alone, batch(7));
  EXPECT_EQ(answer(next, id, batch(7)).substr(id.size()), expected.substr(alone.size()));
}

TEST_F(CheckpointsTest, TakesNoBatchBeyondTheIntervalWhileTheDatabaseRefuses) {
  Process process = with_interval(milliseconds(1));
  const std::string id = create(process);
  SQLite::Database database(file().string(), SQLite::OPEN_READWRITE);
  database.exec(
      "CREATE TRIGGER refusal BEFORE UPDATE ON sessions BEGIN SELECT RAISE(ABORT, 'no'); END");
  std::uint64_t taken = 0;
  while (taken < drive_.scans.size() && process.localization.post_scans(id, batch(taken, 1)))
    ++taken;
  ASSERT_GT(taken, 0U);
  ASSERT_LT(taken, drive_.scans.size());
  EXPECT_EQ(stored(id), 0U);

  database.exec("DROP TRIGGER refusal");
  answer(process, id, batch(taken, 1));
  const auto deadline = Clock::now() + kDeadline;
  while (stored(id) <= taken && Clock::now() < deadline) std::this_thread::yield();
  EXPECT_EQ(stored(id), taken + 1);
}

TEST_F(CheckpointsTest, KeepsUnstoredBatchesWhenAMapChanges) {
  Process process = with_interval(kNever);
  const std::string id = create(process);
  for (std::uint64_t i = 0; i < 3; ++i) answer(process, id, batch(i));
  make_map(process_, "other");
  answer(process, id, batch(3));
  EXPECT_GE(stored(id), 3U);
}

TEST_F(CheckpointsTest, KeepsAResetOfAnotherServer) {
  Process process = with_interval(kNever);
  const std::string id = create(process);
  answer(process, id, batch(0));
  EXPECT_EQ(process.localization.store_all(), 0U);
  answer(process, id, batch(1));
  ASSERT_TRUE(process_.localization.reset(id));
  EXPECT_EQ(process.localization.store_all(), 0U);
  EXPECT_EQ(process.localization.find(id)->expected_sequence, 1U);
  auto again = batch(0);  // Stamps begin anew.
  again.sequence = 1;
  answer(process, id, again);
}

TEST_F(CheckpointsTest, ResetsASessionWithUnstoredBatches) {
  Process process = with_interval(kNever);
  const std::string id = create(process);
  for (std::uint64_t i = 0; i < 3; ++i) answer(process, id, batch(i));
  ASSERT_TRUE(process.localization.reset(id));
  EXPECT_EQ(stored(id), 3U);
  auto again = batch(0);
  again.sequence = 3;
  answer(process, id, again);
}

TEST_F(CheckpointsTest, RemovesASessionWithUnstoredBatches) {
  Process process = with_interval(kNever);
  const std::string id = create(process);
  answer(process, id, batch(0));
  ASSERT_TRUE(process.localization.remove(id));
  EXPECT_EQ(process.localization.store_all(), 0U);
  EXPECT_FALSE(process.localization.find(id));
}

}  // namespace
}  // namespace cornerfix::server

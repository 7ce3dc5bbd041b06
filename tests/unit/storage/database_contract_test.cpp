// What both engines promise of a database: versions, transactions, writers beside each other.
#include <gmock/gmock.h>

#include <barrier>
#include <future>
#include <thread>

#include "storage/map_tables.hpp"
#include "storage/session_store.hpp"
#include "unit/storage/engines.hpp"

namespace cornerfix::storage {
namespace {

constexpr int kShortTimeoutMs = 1;

class DatabaseContract : public EngineTest {
 protected:
  static Result<bool> put(MapStore& maps, const std::string& name) {
    return maps.put(name, std::nullopt, std::nullopt, std::nullopt, "t0");
  }
  static Result<void> insert(SessionStore& sessions, const std::string& id) {
    SessionRecord record;
    record.id = id;
    record.robot = "cart-7";
    record.created = "2024-05-01T00:00:00Z";
    return sessions.insert(record);
  }
  static Result<void> advance(SessionStore& sessions, std::uint64_t sequence) {
    const LocalizerState state;
    return sessions.update("s1", {.previous_sequence = sequence,
                                  .expected_sequence = sequence + 1,
                                  .last_answer = "{}",
                                  .state = &state});
  }

  std::shared_ptr<Database> database_ = databases_.open("maps");
};

INSTANTIATE_TEST_SUITE_P(Engines, DatabaseContract, ::testing::ValuesIn(engines()), EngineName());

TEST_P(DatabaseContract, IsReady) {
  EXPECT_TRUE(database_->probe());
  EXPECT_TRUE(database_->probe_write());
  EXPECT_TRUE(database_->check_in_place());
  EXPECT_TRUE(database_->check_room(1));
  EXPECT_TRUE(database_->check_pages(std::atomic<bool>(false)));
}

TEST_P(DatabaseContract, OpensAgainWithWhatWasStored) {
  MapStore maps(database_);
  ASSERT_TRUE(put(maps, "office"));
  MapStore again(databases_.open("maps"));
  EXPECT_TRUE(again.find("office"));
  MapStore another(database_->open_another(Synchronous::kFull).value());
  EXPECT_TRUE(another.find("office"));
}

TEST_P(DatabaseContract, IsCreatedOnceByProcessesThatStartTogether) {
  constexpr int kThreads = 6;
  std::barrier start(kThreads);
  std::vector<std::string> errors(kThreads);
  const std::string location = databases_.location("fresh");
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&, i] {
        start.arrive_and_wait();
        const auto database = Database::open(location, Synchronous::kFull);
        if (!database) errors[static_cast<std::size_t>(i)] = database.error().message;
      });
    }
  }
  EXPECT_EQ(errors, std::vector<std::string>(kThreads));
}

TEST_P(DatabaseContract, ShowsWhenAnotherConnectionChangedAMap) {
  MapStore other(databases_.open("maps"));
  const std::int64_t before = database_->data_version().value();
  ASSERT_TRUE(put(other, "office"));
  const std::int64_t made = database_->data_version().value();
  EXPECT_NE(made, before);
  const MapInfo map = other.find("office").value();
  const std::vector<PosedScan> key_frames = sample_key_frames(1);
  ASSERT_TRUE(other.grow(map.id, map.revision, {.stamps = {}, .new_key_frames = key_frames}, "t1"));
  const std::int64_t grown = database_->data_version().value();
  EXPECT_NE(grown, made);
  ASSERT_TRUE(other.remove("office"));
  EXPECT_NE(database_->data_version().value(), grown);
}

TEST_P(DatabaseContract, KeepsItsVersionWhileNothingIsWritten) {
  MapStore other(databases_.open("maps"));
  const std::int64_t before = database_->data_version().value();
  EXPECT_FALSE(other.find("office"));
  EXPECT_TRUE(other.list("", 10));
  EXPECT_EQ(database_->data_version().value(), before);
}

TEST_P(DatabaseContract, ShowsAStoreWhenAnotherOneChangedASession) {
  SessionStore ours(database_);
  ASSERT_TRUE(insert(ours, "s1"));
  ASSERT_TRUE(insert(ours, "s2"));
  const auto seen = [&](const std::string& id) {
    return std::pair(database_->data_version().value(), ours.foreign_changes(id).value());
  };
  const auto first = seen("s1");
  const auto untouched = seen("s2");
  ASSERT_TRUE(advance(ours, 0));
  EXPECT_EQ(seen("s1"), first) << "own changes do not count";

  SessionStore theirs(databases_.open("maps"));
  ASSERT_TRUE(advance(theirs, 1));
  const auto second = seen("s1");
  EXPECT_NE(second, first);
  EXPECT_EQ(seen("s1"), second) << "a change counts once";
  EXPECT_EQ(ours.foreign_changes("s2").value(), untouched.second);
  ASSERT_TRUE(advance(ours, 2));
  EXPECT_EQ(seen("s1"), second);
  ASSERT_TRUE(theirs.remove("s1"));
  EXPECT_NE(seen("s1"), second);
}

TEST_P(DatabaseContract, RollsBackWhatIsNotCommitted) {
  MapStore maps(database_);
  {
    const auto transaction = database_->begin(Access::kWrite);
    MapRow row;
    row.info.name = "office";
    EXPECT_GT(database_->maps().insert(row), 0);
  }
  EXPECT_FALSE(maps.find("office"));
  EXPECT_TRUE(put(maps, "office"));
}

TEST_P(DatabaseContract, ReadsOneSnapshotInATransaction) {
  MapStore maps(database_);
  ASSERT_TRUE(put(maps, "office"));
  MapStore other(databases_.open("maps"));
  const auto transaction = database_->begin(Access::kRead);
  EXPECT_EQ(database_->maps().list("", 10).size(), 1U);
  ASSERT_TRUE(put(other, "lab"));
  EXPECT_EQ(database_->maps().list("", 10).size(), 1U);
}

TEST_P(DatabaseContract, GivesUpWaitingForAWriterThatDoesNotEnd) {
  MapStore maps(database_);
  ASSERT_TRUE(put(maps, "office"));
  MapStore other(databases_.try_open("maps", kShortTimeoutMs).value());
  const auto held = database_->begin(Access::kWrite);
  ASSERT_TRUE(database_->maps().find("office"));
  const auto late = other.put("office", "d", std::nullopt, std::nullopt, "t1");
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kUnavailable) << late.error().message;
}

TEST_P(DatabaseContract, LetsOneOfTwoWritersOfARevisionThroughAndRefusesTheOther) {
  MapStore maps(database_);
  ASSERT_TRUE(put(maps, "office"));
  const MapInfo map = maps.find("office").value();
  const std::vector<PosedScan> key_frames = sample_key_frames(3);
  std::barrier start(2);
  const auto grow = [&](const std::string& now) {
    MapStore store(databases_.open("maps"));
    start.arrive_and_wait();
    return store.grow(map.id, map.revision, {.stamps = {}, .new_key_frames = key_frames}, now);
  };
  auto first = std::async(std::launch::async, grow, "t1");
  const auto second = grow("t2");
  const auto other = first.get();
  ASSERT_NE(second.ok(), other.ok());
  EXPECT_EQ((second ? other : second).error().code, ErrorCode::kConflict);
  EXPECT_EQ(maps.find("office")->key_frame_count, 3U);
  EXPECT_EQ(maps.find("office")->updated, second ? "t2" : "t1");
}

TEST_P(DatabaseContract, GoesOnAfterTheIdsThatItWasGiven) {
  database_->set_last_ids({.map = 40, .session = 50, .token = 60});
  const LastIds ids = database_->last_ids();
  EXPECT_EQ(ids.map, 40);
  EXPECT_EQ(ids.session, 50);
  EXPECT_EQ(ids.token, 60);
  MapStore maps(database_);
  ASSERT_TRUE(put(maps, "office"));
  EXPECT_EQ(maps.find("office")->id, 41);
  SessionStore sessions(database_);
  ASSERT_TRUE(insert(sessions, "s1"));
  EXPECT_EQ(sessions.find("s1").value()->number, 51);
}

TEST_P(DatabaseContract, HasNoIdsAtFirst) {
  EXPECT_EQ(database_->last_ids().map, 0);
  database_->set_last_ids({});
  MapStore maps(database_);
  ASSERT_TRUE(put(maps, "office"));
  EXPECT_EQ(maps.find("office")->id, 1);
}

}  // namespace
}  // namespace cornerfix::storage

#include "storage/session_store.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "storage/blob_codec.hpp"
#include "storage/database.hpp"
#include "unit/storage/storage_samples.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::ElementsAre;

class SessionStoreTest : public ::testing::Test {
 protected:
  static SessionRecord record(const std::string& id, const LocalizerState& state = {}) {
    return {.id = id,
            .robot = "cart-7",
            .created = "2024-05-01T00:00:00Z",
            .maps = {"office", "lab", "annex"},
            .lidar_json = "{\"beams\":25}",
            .options_json = "{}",
            .expected_sequence = 0,
            .last_answer = "",
            .state = state,
            .map_ids = {7, 2, 9}};
  }
  /// Stores `state` as the answer to the next sequence.
  Result<void> advance(const LocalizerState& state) {
    const SessionUpdate update{.previous_sequence = sequence_,
                               .expected_sequence = sequence_ + 1,
                               .last_answer = "{\"status\":\"collecting\"}",
                               .state = &state};
    ++sequence_;
    return store_.update("s1", update);
  }
  LocalizerState stored_state() { return store_.find("s1").value().value().state; }
  std::int64_t scalar(const std::string& sql) {
    return database_->connection().execAndGet(sql).getInt64();
  }

  TempDirectory directory_;
  std::shared_ptr<Database> database_ = open_database(directory_ / "sessions.db");
  SessionStore store_{database_};
  std::uint64_t sequence_ = 0;
};

TEST_F(SessionStoreTest, GivesBackASessionBitForBit) {
  SessionRecord session = record("s1", sample_state(3, 12, 5));
  session.expected_sequence = 17;
  session.last_batch = ~std::uint64_t{0};
  session.last_answer = "{\"status\":\"localized\"}";
  ASSERT_TRUE(store_.insert(session));
  EXPECT_TRUE(is_same(store_.find("s1").value().value(), session));
}

TEST_F(SessionStoreTest, GivesBackASessionWithoutMapsOrScans) {
  SessionRecord session = record("s1");
  session.maps.clear();
  session.map_ids.clear();
  ASSERT_TRUE(store_.insert(session));
  EXPECT_TRUE(is_same(store_.find("s1").value().value(), session));
}

TEST_F(SessionStoreTest, FindsNoUnknownSession) { EXPECT_FALSE(store_.find("s1").value()); }

TEST_F(SessionStoreTest, RefusesASecondSessionOfTheSameId) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 2, 0))));
  const Result<void> second = store_.insert(record("s1"));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kConflict);
  EXPECT_EQ(stored_state().submap.size(), 2U);
}

TEST_F(SessionStoreTest, KeepsTheStateOfEveryUpdateBitForBit) {
  ASSERT_TRUE(store_.insert(record("s1")));
  for (int step = 0; step < 8; ++step) {
    const LocalizerState state = sample_state(static_cast<std::uint64_t>(step), 5, step);
    ASSERT_TRUE(advance(state));
    const SessionRecord stored = store_.find("s1").value().value();
    EXPECT_TRUE(is_same(stored.state, state)) << "step " << step;
    EXPECT_EQ(stored.expected_sequence, sequence_);
    EXPECT_EQ(stored.last_answer, "{\"status\":\"collecting\"}");
  }
}

TEST_F(SessionStoreTest, KeepsWhatAnUpdateDoesNotName) {
  ASSERT_TRUE(store_.insert(record("s1")));
  ASSERT_TRUE(advance(LocalizerState{}));
  const SessionRecord stored = store_.find("s1").value().value();
  EXPECT_EQ(stored.robot, "cart-7");
  EXPECT_THAT(stored.maps, ElementsAre("office", "lab", "annex"));
}

TEST_F(SessionStoreTest, WritesNewScansOnlyAndDeletesVanishedOnes) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 4, 0))));
  const auto written = [&] { return database_->connection().getTotalChanges(); };
  const int before = written();
  // Scans 1, 2, 3 stay; 0 goes, 4 comes; and the session's own row.
  ASSERT_TRUE(advance(sample_state(1, 4, 1)));
  EXPECT_EQ(written() - before, 3);
  EXPECT_EQ(scalar("SELECT count(*) FROM submap_scans"), 4);
  EXPECT_EQ(scalar("SELECT min(scan_index) FROM submap_scans"), 1);
}

TEST_F(SessionStoreTest, ForgetsAllScansOnReset) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 6, 0))));
  const LocalizerState fresh;
  ASSERT_TRUE(store_.update(
      "s1", {.previous_sequence = 0, .expected_sequence = 0, .last_answer = "", .state = &fresh}));
  EXPECT_TRUE(is_same(stored_state(), fresh));
  EXPECT_EQ(scalar("SELECT count(*) FROM submap_scans"), 0);
}

TEST_F(SessionStoreTest, TakesScansAfterAResetForOthersThoughTheirIndicesRepeat) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 6, 0))));
  const LocalizerState after_reset = sample_state(0, 3, 100);
  ASSERT_TRUE(advance(after_reset));
  EXPECT_TRUE(is_same(stored_state(), after_reset));
}

TEST_F(SessionStoreTest, TakesAScanForAnotherWhenOneRangeOfItDiffers) {
  LocalizerState state = sample_state(0, 3, 0);
  ASSERT_TRUE(store_.insert(record("s1", state)));
  state.submap[1].scan.ranges[4] = 2.5F;
  ASSERT_TRUE(advance(state));
  EXPECT_TRUE(is_same(stored_state(), state));
}

TEST_F(SessionStoreTest, KeepsTheOrderOfScans) {
  LocalizerState state = sample_state(0, 5, 0);
  std::swap(state.submap[0], state.submap[4]);
  ASSERT_TRUE(store_.insert(record("s1")));
  ASSERT_TRUE(advance(state));
  EXPECT_TRUE(is_same(stored_state(), state));
}

TEST_F(SessionStoreTest, RefusesAnUpdateFromAnotherSequenceAndChangesNothing) {
  const SessionRecord session = record("s1", sample_state(0, 2, 0));
  ASSERT_TRUE(store_.insert(session));
  sequence_ = 1;
  const Result<void> late = advance(sample_state(5, 2, 9));
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kConflict);
  EXPECT_TRUE(is_same(store_.find("s1").value().value(), session));
}

TEST_F(SessionStoreTest, RefusesAnUpdateOfAnUnknownSession) {
  EXPECT_EQ(advance(LocalizerState{}).error().code, ErrorCode::kNotFound);
}

TEST_F(SessionStoreTest, LeavesNothingOfAnUpdateThatTheDiskCannotHold) {
  const SessionRecord session = record("s1", sample_state(0, 2, 0));
  ASSERT_TRUE(store_.insert(session));
  const std::int64_t pages = scalar("PRAGMA page_count");
  database_->connection().exec("PRAGMA max_page_count = " + std::to_string(pages + 2));
  const Result<void> failed = advance(sample_state(2, 400, 9));
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kStorageFull);
  EXPECT_TRUE(is_same(store_.find("s1").value().value(), session));
}

TEST_F(SessionStoreTest, RemovesAllOfASessionAndNothingElse) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 3, 0))));
  ASSERT_TRUE(store_.insert(record("s2", sample_state(0, 2, 0))));
  ASSERT_TRUE(store_.remove("s1"));
  EXPECT_FALSE(store_.find("s1").value());
  EXPECT_EQ(scalar("SELECT count(*) FROM submap_scans"), 2);
  EXPECT_EQ(scalar("SELECT count(*) FROM session_maps"), 3);
}

TEST_F(SessionStoreTest, RemovesNoUnknownSession) {
  EXPECT_EQ(store_.remove("s1").error().code, ErrorCode::kNotFound);
}

TEST_F(SessionStoreTest, ListsSessionsByCreationInPages) {
  for (const char* id : {"c", "a", "b"}) {
    SessionRecord session = record(id, sample_state(0, 1, 0));
    session.robot = std::string("cart-") + id;
    ASSERT_TRUE(store_.insert(session));
  }
  const auto ids = [&](const SessionPage& page) {
    std::vector<std::string> found;
    const std::vector<SessionRecord> stored = store_.list(page).value();
    for (const SessionRecord& session : stored) found.push_back(session.id);
    return found;
  };
  EXPECT_THAT(ids({}), ElementsAre("c", "a", "b"));
  EXPECT_THAT(ids({.limit = 2}), ElementsAre("c", "a"));
  const std::int64_t after = store_.list({.limit = 2}).value().back().number;
  EXPECT_THAT(ids({.after = after}), ElementsAre("b"));
  EXPECT_THAT(ids({.robot = "cart-b"}), ElementsAre("b"));
  EXPECT_EQ(store_.count("cart-b").value(), 1U);
  EXPECT_EQ(store_.count("cart-x").value(), 0U);
}

TEST_F(SessionStoreTest, RemovesSessionsThatWereNotUsedSinceATime) {
  ASSERT_TRUE(store_.insert(record("s1")));
  ASSERT_TRUE(store_.insert(record("s2")));
  const LocalizerState state = sample_state(0, 1, 0);
  const SessionUpdate used{
      .expected_sequence = 1, .last_answer = "{}", .state = &state, .now = "2024-05-03T00:00:00Z"};
  ASSERT_TRUE(store_.update("s1", used));
  EXPECT_EQ(store_.find("s1").value().value().last_used, "2024-05-03T00:00:00Z");
  EXPECT_EQ(store_.find("s2").value().value().last_used, "2024-05-01T00:00:00Z");
  EXPECT_EQ(store_.remove_unused_since("2024-05-02T00:00:00Z").value(), 1U);
  EXPECT_TRUE(store_.find("s1").value().has_value());
  EXPECT_FALSE(store_.find("s2").value().has_value());
}

TEST_F(SessionStoreTest, NamesTheSessionThatCannotBeRead) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 3, 0))));
  database_->connection().exec("DELETE FROM submap_scans WHERE scan_index = 1");
  const auto found = store_.find("s1");
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kCorruptData);
  EXPECT_THAT(found.error().message, ::testing::HasSubstr("session s1"));
}

TEST_F(SessionStoreTest, RefusesASubmapScanThatTheStateDoesNotName) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 2, 0))));
  const Blob other = encode_submap_scan(sample_submap_scan(1, 50));
  SQLite::Statement exchange(database_->connection(),
                             "UPDATE submap_scans SET scan = ? WHERE scan_index = 1");
  exchange.bind(1, other.data(), static_cast<int>(other.size()));
  exchange.exec();
  EXPECT_EQ(store_.find("s1").error().code, ErrorCode::kCorruptData);
}

TEST_F(SessionStoreTest, ShowsAnAcknowledgedUpdateToASecondConnectionAtOnce) {
  SessionStore other(open_database(directory_ / "sessions.db"));
  ASSERT_TRUE(store_.insert(record("s1")));
  const LocalizerState state = sample_state(0, 3, 1);
  ASSERT_TRUE(advance(state));
  EXPECT_TRUE(is_same(other.find("s1").value().value().state, state));
}

TEST_F(SessionStoreTest, KnowsTheNewestSessionOfARobot) {
  const std::string robot = record("s1").robot;
  EXPECT_EQ(store_.newest(robot).value(), "");
  ASSERT_TRUE(store_.insert(record("s1")));
  ASSERT_TRUE(store_.insert(record("a2")));
  EXPECT_EQ(store_.newest(robot).value(), "a2");
  EXPECT_EQ(store_.newest(robot + "0").value(), "");
  ASSERT_TRUE(store_.remove("a2"));
  EXPECT_EQ(store_.newest(robot).value(), "s1");
}

TEST_F(SessionStoreTest, TakesEachSequenceFromOneOfTwoServersOnly) {
  ASSERT_TRUE(store_.insert(record("s1")));
  constexpr std::uint64_t kBatches = 200;
  std::atomic<std::uint64_t> accepted = 0;
  const auto serve = [&](int server) {
    SessionStore store(open_database(directory_ / "sessions.db"));
    for (std::uint64_t sequence = 0; sequence < kBatches; ++sequence) {
      const LocalizerState state = sample_state(sequence, 2, server);
      const Result<void> done = store.update("s1", {.previous_sequence = sequence,
                                                    .expected_sequence = sequence + 1,
                                                    .last_answer = "answer",
                                                    .state = &state});
      if (done) {
        ++accepted;
      } else {
        ASSERT_EQ(done.error().code, ErrorCode::kConflict) << done.error().message;
        // The other one is behind or ahead: go where the session expects.
        sequence = store.find("s1").value()->expected_sequence - 1;
      }
    }
  };
  {
    const std::jthread first(serve, 0);
    const std::jthread second(serve, 1);
  }
  EXPECT_EQ(accepted, kBatches);
  EXPECT_EQ(store_.find("s1").value()->expected_sequence, kBatches);
}

}  // namespace
}  // namespace cornerfix::storage

#include "storage/session_store.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "storage/blob_codec.hpp"
#include "unit/storage/engines.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::ElementsAre;

class SessionStoreTest : public EngineTest {
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
  std::int64_t scalar(const std::string& sql) { return databases_.run("sessions", sql); }

  std::shared_ptr<Database> database_ = databases_.open("sessions");
  SessionStore store_{database_};
  std::uint64_t sequence_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Engines, SessionStoreTest, ::testing::ValuesIn(engines()), EngineName());

TEST_P(SessionStoreTest, GivesBackASessionBitForBit) {
  SessionRecord session = record("s1", sample_state(3, 12, 5));
  session.expected_sequence = 17;
  session.last_batch = ~std::uint64_t{0};
  session.last_answer = "{\"status\":\"localized\"}";
  ASSERT_TRUE(store_.insert(session));
  EXPECT_TRUE(is_same(store_.find("s1").value().value(), session));
}

TEST_P(SessionStoreTest, GivesBackASessionWithoutMapsOrScans) {
  SessionRecord session = record("s1");
  session.maps.clear();
  session.map_ids.clear();
  ASSERT_TRUE(store_.insert(session));
  EXPECT_TRUE(is_same(store_.find("s1").value().value(), session));
}

TEST_P(SessionStoreTest, FindsNoUnknownSession) { EXPECT_FALSE(store_.find("s1").value()); }

TEST_P(SessionStoreTest, RefusesASecondSessionOfTheSameId) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 2, 0))));
  const Result<void> second = store_.insert(record("s1"));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kConflict);
  EXPECT_EQ(stored_state().submap.size(), 2U);
}

TEST_P(SessionStoreTest, KeepsTheStateOfEveryUpdateBitForBit) {
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

TEST_P(SessionStoreTest, KeepsWhatAnUpdateDoesNotName) {
  ASSERT_TRUE(store_.insert(record("s1")));
  ASSERT_TRUE(advance(LocalizerState{}));
  const SessionRecord stored = store_.find("s1").value().value();
  EXPECT_EQ(stored.robot, "cart-7");
  EXPECT_THAT(stored.maps, ElementsAre("office", "lab", "annex"));
}

TEST_P(SessionStoreTest, ForgetsAllScansOnReset) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 6, 0))));
  const LocalizerState fresh;
  ASSERT_TRUE(store_.update(
      "s1", {.previous_sequence = 0, .expected_sequence = 0, .last_answer = "", .state = &fresh}));
  EXPECT_TRUE(is_same(stored_state(), fresh));
  EXPECT_EQ(scalar("SELECT count(*) FROM submap_scans"), 0);
}

TEST_P(SessionStoreTest, TakesScansAfterAResetForOthersThoughTheirIndicesRepeat) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 6, 0))));
  const LocalizerState after_reset = sample_state(0, 3, 100);
  ASSERT_TRUE(advance(after_reset));
  EXPECT_TRUE(is_same(stored_state(), after_reset));
}

TEST_P(SessionStoreTest, TakesAScanForAnotherWhenOneRangeOfItDiffers) {
  LocalizerState state = sample_state(0, 3, 0);
  ASSERT_TRUE(store_.insert(record("s1", state)));
  SubmapScan changed = *state.submap[1];
  changed.scan.ranges[4] = 2.5F;
  state.submap[1] = std::make_shared<const SubmapScan>(changed);
  ASSERT_TRUE(advance(state));
  EXPECT_TRUE(is_same(stored_state(), state));
}

TEST_P(SessionStoreTest, KeepsTheOrderOfScans) {
  LocalizerState state = sample_state(0, 5, 0);
  std::swap(state.submap[0], state.submap[4]);
  ASSERT_TRUE(store_.insert(record("s1")));
  ASSERT_TRUE(advance(state));
  EXPECT_TRUE(is_same(stored_state(), state));
}

TEST_P(SessionStoreTest, RefusesAnUpdateFromAnotherSequenceAndChangesNothing) {
  const SessionRecord session = record("s1", sample_state(0, 2, 0));
  ASSERT_TRUE(store_.insert(session));
  sequence_ = 1;
  const Result<void> late = advance(sample_state(5, 2, 9));
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kConflict);
  EXPECT_TRUE(is_same(store_.find("s1").value().value(), session));
}

TEST_P(SessionStoreTest, StoresSeveralSessionsTogetherButForThoseThatItRefuses) {
  for (const char* id : {"s1", "s2", "s3"})
    ASSERT_TRUE(store_.insert(record(id, sample_state(0, 2, 0))));
  const LocalizerState state = sample_state(1, 4, 3);
  const SessionUpdate next{.expected_sequence = 1, .last_answer = "a", .state = &state};
  SessionUpdate late = next;
  late.previous_sequence = 7;
  const std::vector<SessionChange> changes = {
      {"s3", next}, {"s2", late}, {"nobody", next}, {"s1", next}};
  const std::vector<Result<void>> results = store_.update(changes);
  ASSERT_EQ(results.size(), 4U);
  EXPECT_TRUE(results[0]);
  EXPECT_EQ(results[1].error().code, ErrorCode::kConflict);
  EXPECT_EQ(results[2].error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(results[3]);
  for (const char* id : {"s1", "s3"}) {
    EXPECT_EQ(store_.find(id).value()->expected_sequence, 1U);
    EXPECT_TRUE(is_same(store_.find(id).value()->state, state));
  }
  EXPECT_TRUE(is_same(store_.find("s2").value()->state, sample_state(0, 2, 0)));
}

TEST_P(SessionStoreTest, RefusesAnUpdateWhoseSessionWasResetMeanwhile) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 2, 0))));
  const LocalizerState forgotten;
  ASSERT_TRUE(store_.update("s1", {.last_answer = "a", .state = &forgotten}));
  const LocalizerState state = sample_state(1, 4, 3);
  const std::uint64_t scans = sample_state(0, 2, 0).scans;
  ASSERT_NE(scans, 0U);
  const SessionUpdate next{
      .expected_sequence = 1, .last_answer = "a", .state = &state, .previous_scans = scans};
  EXPECT_EQ(store_.update("s1", next).error().code, ErrorCode::kConflict);
}

TEST_P(SessionStoreTest, RefusesAnUpdateOfAnUnknownSession) {
  EXPECT_EQ(advance(LocalizerState{}).error().code, ErrorCode::kNotFound);
}

TEST_P(SessionStoreTest, RemovesAllOfASessionAndNothingElse) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 3, 0))));
  ASSERT_TRUE(store_.insert(record("s2", sample_state(0, 2, 0))));
  ASSERT_TRUE(store_.remove("s1"));
  EXPECT_FALSE(store_.find("s1").value());
  EXPECT_EQ(scalar("SELECT count(*) FROM submap_scans"), 2);
  EXPECT_EQ(scalar("SELECT count(*) FROM session_maps"), 3);
}

TEST_P(SessionStoreTest, RemovesNoUnknownSession) {
  EXPECT_EQ(store_.remove("s1").error().code, ErrorCode::kNotFound);
}

TEST_P(SessionStoreTest, ListsSessionsByCreationInPages) {
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

TEST_P(SessionStoreTest, RemovesSessionsThatWereNotUsedSinceATime) {
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

TEST_P(SessionStoreTest, NamesTheSessionThatCannotBeRead) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 3, 0))));
  databases_.run("sessions", "DELETE FROM submap_scans WHERE scan_index = 1");
  const auto found = store_.find("s1");
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kCorruptData);
  EXPECT_THAT(found.error().message, ::testing::HasSubstr("session s1"));
}

TEST_P(SessionStoreTest, RefusesASubmapScanThatTheStateDoesNotName) {
  ASSERT_TRUE(store_.insert(record("s1", sample_state(0, 2, 0))));
  const Blob other = encode_submap_scan(sample_submap_scan(1, 50));
  databases_.run("sessions", "UPDATE submap_scans SET scan = " + databases_.literal(other) +
                                 " WHERE scan_index = 1");
  EXPECT_EQ(store_.find("s1").error().code, ErrorCode::kCorruptData);
}

TEST_P(SessionStoreTest, ShowsAnAcknowledgedUpdateToASecondConnectionAtOnce) {
  SessionStore other(databases_.open("sessions"));
  ASSERT_TRUE(store_.insert(record("s1")));
  const LocalizerState state = sample_state(0, 3, 1);
  ASSERT_TRUE(advance(state));
  EXPECT_TRUE(is_same(other.find("s1").value().value().state, state));
}

TEST_P(SessionStoreTest, KnowsTheNewestSessionOfARobot) {
  const std::string robot = record("s1").robot;
  EXPECT_EQ(store_.newest(robot).value(), "");
  ASSERT_TRUE(store_.insert(record("s1")));
  ASSERT_TRUE(store_.insert(record("a2")));
  EXPECT_EQ(store_.newest(robot).value(), "a2");
  EXPECT_EQ(store_.newest(robot + "0").value(), "");
  ASSERT_TRUE(store_.remove("a2"));
  EXPECT_EQ(store_.newest(robot).value(), "s1");
}

TEST_P(SessionStoreTest, TakesEachSequenceFromOneOfTwoServersOnly) {
  ASSERT_TRUE(store_.insert(record("s1")));
  constexpr std::uint64_t kBatches = 200;
  std::atomic<std::uint64_t> accepted = 0;
  const auto serve = [&](int server) {
    SessionStore store(databases_.open("sessions"));
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

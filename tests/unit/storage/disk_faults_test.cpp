// Disks that are full or broken at every write there is: what was acknowledged before stays, what
// was refused is not there, and the file can be opened again.
#include <gmock/gmock.h>

#include <string>

#include "storage/map_store.hpp"
#include "storage/session_store.hpp"
#include "storage/sqlite/sqlite_database.hpp"
#include "unit/storage/failing_vfs.hpp"
#include "unit/storage/storage_samples.hpp"

namespace cornerfix::storage {
namespace {

constexpr int kMostSteps = 400;  // More than any of the changes below needs.

class DiskFaults : public ::testing::TestWithParam<int> {
 protected:
  SessionUpdate next_batch(const LocalizerState& state) const {
    return {.previous_sequence = sequence_,
            .expected_sequence = sequence_ + 1,
            .last_answer = "{}",
            .state = &state,
            .now = "2024-05-01T00:00:01Z"};
  }

  /// Opens the file anew, as after a crash, and looks for what was acknowledged.
  void check_file(const LocalizerState& acknowledged) {
    const auto database = SqliteDatabase::open(file_, Synchronous::kNormal);
    ASSERT_TRUE(database) << database.error().message;
    const auto session = SessionStore(*database).find("s1").value();
    ASSERT_TRUE(session.has_value());
    EXPECT_EQ(session->expected_sequence, sequence_);
    EXPECT_TRUE(is_same(session->state, acknowledged));
  }

  testing::FailingVfs disk_;
  TempDirectory directory_;
  std::filesystem::path file_ = directory_ / "faults.db";
  std::uint64_t sequence_ = 0;
};

TEST_P(DiskFaults, LoseNoBatchThatWasAcknowledged) {
  {
    const auto database = open_database(file_);
    SessionRecord record;
    record.id = "s1";
    record.robot = "cart-7";
    record.created = "2024-05-01T00:00:00Z";
    ASSERT_TRUE(SessionStore(database).insert(record));
  }
  LocalizerState acknowledged;
  int refused = 0;
  for (int steps = 0; steps < kMostSteps; ++steps) {
    const LocalizerState state = sample_state(static_cast<std::uint64_t>(steps), 12, steps);
    bool has_failed = false;
    {
      const auto database = SqliteDatabase::open(file_, Synchronous::kFull).value();
      SessionStore store(database);
      disk_.arm(steps, GetParam());
      const auto stored = store.update("s1", next_batch(state));
      has_failed = disk_.disarm();
      if (stored) {
        acknowledged = state;
        ++sequence_;
      } else {
        ++refused;
        EXPECT_NE(stored.error().code, ErrorCode::kInternal) << stored.error().message;
      }
      // Goes on with the same connection once there is room.
      const auto again = store.update("s1", next_batch(state));
      ASSERT_TRUE(again) << steps << " steps: " << again.error().message;
      acknowledged = state;
      ++sequence_;
    }
    check_file(acknowledged);
    if (!has_failed) break;
    ASSERT_LT(steps, kMostSteps - 1);
  }
  EXPECT_GT(refused, 3);
}

/// A growth that was refused may still be there after a failed sync, but then as a whole, with what
/// was derived of it.
TEST_P(DiskFaults, LeaveNoHalfOfAMap) {
  std::uint64_t revision = 0;
  {
    MapStore store(open_database(file_));
    ASSERT_TRUE(store.put("office", {}, {}, {}, "2024-05-01T00:00:00Z"));
    revision = store.find("office")->revision;
  }
  std::size_t key_frames = 0;
  bool was_acknowledged = false;
  for (int steps = 0; steps < kMostSteps && !was_acknowledged; ++steps) {
    {
      MapStore store(SqliteDatabase::open(file_, Synchronous::kFull).value());
      const std::vector<double> stamps = {1000.0 + steps};
      const std::vector<PosedScan> frames = {sample_key_frame(steps)};
      const MapContent content = sample_content(3 + steps % 5);
      const MapSketch sketch = sample_sketch(steps);
      const MapGrowth growth{
          .stamps = stamps, .new_key_frames = frames, .content = &content, .sketch = &sketch};
      disk_.arm(steps, GetParam());
      const auto grown = store.grow(store.find("office")->id, revision, growth, "now");
      was_acknowledged = !disk_.disarm() && grown;
    }
    MapStore store(SqliteDatabase::open(file_, Synchronous::kFull).value());
    const auto info = store.find("office");
    const std::size_t growths = info->revision - revision;
    EXPECT_EQ(info->key_frame_count, key_frames + growths);
    EXPECT_EQ(store.key_frames(info->id)->size(), key_frames + growths);
    if (info->key_frame_count > 0) {
      const auto content = store.content(info->id).value();
      EXPECT_EQ(content->revision, info->revision);
      EXPECT_EQ(content->content.features.size(), info->feature_count);
      EXPECT_EQ(store.sketch_states()->front().sketch_revision, info->revision);
    }
    EXPECT_TRUE(growths == 1 || (growths == 0 && !was_acknowledged));
    revision = info->revision;
    key_frames += growths;
  }
  EXPECT_TRUE(was_acknowledged);
}

INSTANTIATE_TEST_SUITE_P(Codes, DiskFaults,
                         ::testing::Values(SQLITE_FULL, SQLITE_IOERR_WRITE, SQLITE_IOERR_FSYNC),
                         [](const auto& code) -> std::string {
                           if (code.param == SQLITE_FULL) return "Full";
                           return code.param == SQLITE_IOERR_WRITE ? "Write" : "Sync";
                         });

}  // namespace
}  // namespace cornerfix::storage

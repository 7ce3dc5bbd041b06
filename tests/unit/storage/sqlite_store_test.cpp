// What the stores promise on SQLite alone: how much they write, and full disks.
#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include "storage/map_store.hpp"
#include "storage/session_store.hpp"
#include "unit/storage/storage_samples.hpp"

namespace cornerfix::storage {
namespace {

class SqliteStoreTest : public ::testing::Test {
 protected:
  void insert_session(const LocalizerState& state) {
    SessionRecord record;
    record.id = "s1";
    record.robot = "cart-7";
    record.created = "2024-05-01T00:00:00Z";
    record.state = state;
    ASSERT_TRUE(sessions_.insert(record));
  }
  Result<void> advance(const LocalizerState& state) {
    return sessions_.update(
        "s1",
        {.previous_sequence = 0, .expected_sequence = 1, .last_answer = "{}", .state = &state});
  }
  std::int64_t scalar(const std::string& sql) {
    return database_->connection().execAndGet(sql).getInt64();
  }
  /// Leaves the file that many pages to grow.
  void limit_pages(std::int64_t pages) {
    database_->connection().exec("PRAGMA max_page_count = " +
                                 std::to_string(scalar("PRAGMA page_count") + pages));
  }

  TempDirectory directory_;
  std::shared_ptr<SqliteDatabase> database_ = open_database(directory_ / "test.db");
  MapStore maps_{database_};
  SessionStore sessions_{database_};
};

TEST_F(SqliteStoreTest, WritesNewScansOnlyAndDeletesVanishedOnes) {
  insert_session(sample_state(0, 4, 0));
  const int before = database_->connection().getTotalChanges();
  // Scans 1, 2, 3 stay; 0 goes, 4 comes; and the session's own row.
  ASSERT_TRUE(advance(sample_state(1, 4, 1)));
  EXPECT_EQ(database_->connection().getTotalChanges() - before, 3);
  EXPECT_EQ(scalar("SELECT count(*) FROM submap_scans"), 4);
  EXPECT_EQ(scalar("SELECT min(scan_index) FROM submap_scans"), 1);
}

TEST_F(SqliteStoreTest, LeavesNothingOfAnUpdateThatTheDiskCannotHold) {
  const LocalizerState state = sample_state(0, 2, 0);
  insert_session(state);
  limit_pages(2);
  const Result<void> failed = advance(sample_state(2, 400, 9));
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kStorageFull);
  EXPECT_TRUE(is_same(sessions_.find("s1").value()->state, state));
}

TEST_F(SqliteStoreTest, LeavesNothingOfAGrowthThatTheDiskCannotHold) {
  ASSERT_TRUE(maps_.put("office", std::nullopt, std::nullopt, std::nullopt, "t0"));
  const MapInfo map = maps_.find("office").value();
  limit_pages(5);
  const std::vector<PosedScan> key_frames = sample_key_frames(500);
  const auto failed =
      maps_.grow(map.id, map.revision, {.stamps = {}, .new_key_frames = key_frames}, "t9");
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kStorageFull);
  EXPECT_EQ(maps_.find("office")->revision, map.revision);
  EXPECT_EQ(scalar("SELECT count(*) FROM key_frames"), 0);
}

}  // namespace
}  // namespace cornerfix::storage

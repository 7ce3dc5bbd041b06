#include "storage/sqlite/schema.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <array>

#include "storage/map_store.hpp"
#include "unit/storage/storage_samples.hpp"

namespace cornerfix::storage {
namespace {

constexpr std::array<const char*, 2> kTwoSteps = {
    "CREATE TABLE corners (x REAL NOT NULL) STRICT; INSERT INTO corners VALUES (1.5);",
    "ALTER TABLE corners ADD COLUMN y REAL; UPDATE corners SET y = 2 * x;"};
constexpr std::array<const char*, 2> kBrokenSecondStep = {kTwoSteps[0],
                                                          "CREATE TABLE other (x INTEGER) STRICT; "
                                                          "INSERT INTO nowhere VALUES (1);"};

SQLite::Database memory_database() {
  return SQLite::Database(":memory:", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
}

TEST(Schema, MigratesAnEmptyFileThroughAllSteps) {
  SQLite::Database database = memory_database();
  ASSERT_TRUE(migrate(database, kTwoSteps));
  EXPECT_EQ(user_version(database), 2);
  EXPECT_EQ(database.execAndGet("PRAGMA application_id").getInt64(), kApplicationId);
  EXPECT_EQ(database.execAndGet("SELECT y FROM corners").getDouble(), 3.0);
}

TEST(Schema, AppliesOnlyTheStepsThatAFileLacks) {
  SQLite::Database database = memory_database();
  ASSERT_TRUE(migrate(database, std::span(kTwoSteps).first(1)));
  database.exec("UPDATE corners SET x = 4");
  ASSERT_TRUE(migrate(database, kTwoSteps));
  EXPECT_EQ(database.execAndGet("SELECT y FROM corners").getDouble(), 8.0);
}

TEST(Schema, LeavesAFileOfTheNewestSchemaAlone) {
  SQLite::Database database = memory_database();
  ASSERT_TRUE(migrate(database, kTwoSteps));
  const int changes = database.getTotalChanges();
  ASSERT_TRUE(migrate(database, kTwoSteps));
  EXPECT_EQ(database.getTotalChanges(), changes);
}

TEST(Schema, TakesNoStepWhenOneOfThemFails) {
  SQLite::Database database = memory_database();
  EXPECT_THROW((void)migrate(database, kBrokenSecondStep), SQLite::Exception);
  EXPECT_EQ(user_version(database), 0);
  EXPECT_FALSE(database.tableExists("corners"));
}

TEST(Schema, RefusesANewerFile) {
  SQLite::Database database = memory_database();
  ASSERT_TRUE(migrate(database, kTwoSteps));
  const Result<void> refused = migrate(database, std::span(kTwoSteps).first(1));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(user_version(database), 2);
}

/// Every schema that was ever written, and the empty file as number 0.
class OlderSchema : public ::testing::TestWithParam<std::size_t> {};

INSTANTIATE_TEST_SUITE_P(Versions, OlderSchema,
                         ::testing::Range<std::size_t>(0, migrations().size() + 1));

TEST_P(OlderSchema, OpensAndServes) {
  const TempDirectory directory;
  {
    SQLite::Database older((directory / "maps.db").string(),
                           SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    ASSERT_TRUE(migrate(older, migrations().first(GetParam())));
  }
  MapStore store(open_database(directory / "maps.db"));
  ASSERT_TRUE(store.put("office", std::nullopt, std::nullopt, std::nullopt, "now"));
  EXPECT_EQ(store.find("office")->name, "office");
}

TEST(Schema, TakesMapsOfOlderSchemasForMapsAtPoses) {
  const TempDirectory directory;
  {
    SQLite::Database older((directory / "maps.db").string(),
                           SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    ASSERT_TRUE(migrate(older, migrations().first(2)));
    older.exec(
        "INSERT INTO maps (name, description, revision, digest, key_frame_chain, key_frame_count, "
        "feature_count, created, updated, lidar_json, parameters_json) VALUES ('office', '', 7, "
        "'abc', zeroblob(32), 0, 0, 't0', 't1', '', '')");
  }
  MapStore store(open_database(directory / "maps.db"));
  const MapInfo map = store.find("office").value();
  EXPECT_FALSE(map.drifts);
  EXPECT_FALSE(map.has_floor_map);
  EXPECT_EQ(map.revision, 7U);
  EXPECT_EQ(map.digest, "abc");
}

TEST(Schema, HasStrictTablesOnly) {
  SQLite::Database database = memory_database();
  ASSERT_TRUE(migrate(database, migrations()));
  const int lax = database
                      .execAndGet(
                          "SELECT count(*) FROM pragma_table_list WHERE strict = 0 AND "
                          "name NOT LIKE 'sqlite_%'")
                      .getInt();
  EXPECT_EQ(lax, 0);
}

}  // namespace
}  // namespace cornerfix::storage

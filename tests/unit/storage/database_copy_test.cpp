#include "storage/database_copy.hpp"

#include <gmock/gmock.h>

#include "storage/job_store.hpp"
#include "storage/map_store.hpp"
#include "storage/session_store.hpp"
#include "storage/token_store.hpp"
#include "unit/storage/engines.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::HasSubstr;

struct Direction {
  Engine from = Engine::kSqlite;
  Engine to = Engine::kSqlite;
};

std::vector<Direction> directions() {
  std::vector<Direction> directions;
  for (const Engine from : engines()) {
    for (const Engine to : engines()) directions.push_back({from, to});
  }
  return directions;
}

class DatabaseCopy : public ::testing::TestWithParam<Direction> {
 protected:
  void SetUp() override {
    skip_without(from_databases_);
    if (IsSkipped()) return;
    skip_without(to_databases_);
  }
  static void skip_without(const TestDatabases& databases) {
    if (databases.obstacle().empty()) return;
    if (std::getenv("CORNERFIX_REQUIRE_TOOLS") != nullptr) FAIL() << databases.obstacle();
    GTEST_SKIP() << databases.obstacle();
  }

  void fill_source() {
    MapStore maps(from_);
    const std::vector<PosedScan> key_frames = sample_key_frames(7);
    const std::vector<double> stamps = {-0.0, 1.5, 1e9 + 1e-6};
    for (const std::string name : {"deleted", "office", "Lab"}) {
      ASSERT_TRUE(maps.put(name, std::string_view("with \0 inside", 13), "lidar", "params", "t0"));
      const MapInfo map = maps.find(name).value();
      const MapInfo grown =
          maps.grow(map.id, map.revision,
                    {.stamps = stamps,
                     .new_key_frames = key_frames,
                     .outline = {.feature_count = 3, .bounds = Bounds{{1, 2}, {3, 4}}},
                     .drifts = name == "Lab"},
                    "t1")
              .value();
      ASSERT_TRUE(maps.store_content(grown.id, grown.revision, sample_content(5)));
      ASSERT_TRUE(maps.store_sketch(grown.id, grown.revision, sample_sketch(6)));
    }
    ASSERT_TRUE(maps.remove("deleted"));
    ASSERT_TRUE(maps.put("empty", std::nullopt, std::nullopt, std::nullopt, "t0"));
    const OccupancyGrid plan = sample_content(1).grid;
    ASSERT_TRUE(maps.put_floor_map("plan", {.grid = plan}, "t2"));
    SessionStore sessions(from_);
    for (const std::string id : {"gone", "s1", "s2"}) {
      ASSERT_TRUE(sessions.insert({.id = id,
                                   .robot = "cart-7",
                                   .created = "2024-05-01T00:00:00Z",
                                   .maps = {"office", "deleted"},
                                   .lidar_json = "{}",
                                   .options_json = "[]",
                                   .expected_sequence = 9,
                                   .last_answer = "{\"a\":1}",
                                   .state = sample_state(3, 4, 1),
                                   .map_ids = {2, 1},
                                   .last_used = "2024-05-02T00:00:00Z",
                                   .last_batch = ~std::uint64_t{0}}));
    }
    ASSERT_TRUE(sessions.remove("gone"));
    TokenStore tokens(from_);
    ASSERT_TRUE(tokens.insert({.name = "me", .role = "admin", .hash = hash_of_token("a")}));
  }

  TestDatabases from_databases_{GetParam().from};
  TestDatabases to_databases_{GetParam().to};
  std::shared_ptr<Database> from_ = from_databases_.open("source");
  std::shared_ptr<Database> to_ = to_databases_.open("target");
};

INSTANTIATE_TEST_SUITE_P(Engines, DatabaseCopy, ::testing::ValuesIn(directions()),
                         [](const auto& test) {
                           return name_of(test.param.from) + "To" + name_of(test.param.to);
                         });

TEST_P(DatabaseCopy, CopiesEveryMap) {
  ASSERT_NO_FATAL_FAILURE(fill_source());
  const auto copied = copy_database(from_, to_);
  ASSERT_TRUE(copied) << copied.error().message;
  EXPECT_EQ(copied->maps, 4U);
  MapStore source(from_);
  MapStore target(to_);
  const std::vector<MapInfo> infos = source.list("", 10).value();
  ASSERT_EQ(infos.size(), 4U);
  for (const MapInfo& info : infos) {
    const MapInfo copy = target.find(info.name).value();
    EXPECT_EQ(copy.id, info.id);
    EXPECT_EQ(copy.description, info.description);
    EXPECT_EQ(copy.revision, info.revision);
    EXPECT_EQ(copy.digest, info.digest);
    EXPECT_EQ(copy.updated, info.updated);
    EXPECT_EQ(copy.created, info.created);
    EXPECT_EQ(copy.drifts, info.drifts);
    EXPECT_EQ(copy.has_floor_map, info.has_floor_map);
    EXPECT_EQ(copy.feature_count, info.feature_count);
    const MapArchive from = source.archive(info.name).value();
    const MapArchive to = target.archive(info.name).value();
    EXPECT_EQ(to.stamps, from.stamps);
    EXPECT_TRUE(is_same(to.key_frames, from.key_frames));
    EXPECT_EQ(to.floor_map, from.floor_map);
  }
  const std::int64_t office = target.find("office")->id;
  const SketchPage sketches = target.sketches(0, 10).value();
  ASSERT_EQ(sketches.sketches.size(), 2U);
  EXPECT_EQ(sketches.sketches[0].map_id, office);
  EXPECT_EQ(sketches.sketches[0].sketch, sample_sketch(6));
  EXPECT_TRUE(is_same(target.content(office).value()->content, sample_content(5)));
}

TEST_P(DatabaseCopy, CopiesFormerRevisions) {
  ASSERT_NO_FATAL_FAILURE(fill_source());
  MapStore source(from_);
  ASSERT_TRUE(source.put("office", std::nullopt, std::nullopt, "other", "t3"));
  ASSERT_TRUE(copy_database(from_, to_));
  MapStore target(to_);
  const std::vector<MapRevision> from = source.revisions("office").value();
  const std::vector<MapRevision> to = target.revisions("office").value();
  ASSERT_EQ(from.size(), 2U);
  ASSERT_EQ(to.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(to[i].revision, from[i].revision);
    EXPECT_EQ(to[i].digest, from[i].digest);
    EXPECT_EQ(to[i].created, from[i].created);
    EXPECT_EQ(to[i].origin, from[i].origin);
    EXPECT_EQ(to[i].archive_bytes, from[i].archive_bytes);
  }
}

TEST_P(DatabaseCopy, CopiesEverySessionAndToken) {
  ASSERT_NO_FATAL_FAILURE(fill_source());
  const auto copied = copy_database(from_, to_);
  ASSERT_TRUE(copied) << copied.error().message;
  EXPECT_EQ(copied->sessions, 2U);
  EXPECT_EQ(copied->tokens, 1U);
  SessionStore source(from_);
  SessionStore target(to_);
  for (const std::string id : {"s1", "s2"}) {
    const SessionRecord from = source.find(id).value().value();
    const SessionRecord to = target.find(id).value().value();
    EXPECT_TRUE(is_same(to, from));
    EXPECT_EQ(to.number, from.number);
    EXPECT_EQ(to.last_used, from.last_used);
  }
  TokenStore tokens(to_);
  EXPECT_EQ(tokens.list().value().at(0).hash, hash_of_token("a"));
}

TEST_P(DatabaseCopy, GivesNoIdOfTheSourceToAnotherMapOfTheTarget) {
  ASSERT_NO_FATAL_FAILURE(fill_source());
  ASSERT_TRUE(MapStore(from_).remove("plan"));
  const LastIds ids = from_->last_ids();
  ASSERT_TRUE(copy_database(from_, to_));
  MapStore target(to_);
  ASSERT_TRUE(target.put("new", std::nullopt, std::nullopt, std::nullopt, "t3"));
  EXPECT_GT(target.find("new")->id, ids.map);
}

TEST_P(DatabaseCopy, CopiesAnEmptyDatabase) {
  const auto copied = copy_database(from_, to_);
  ASSERT_TRUE(copied) << copied.error().message;
  EXPECT_EQ(copied->maps + copied->sessions + copied->tokens, 0U);
}

TEST_P(DatabaseCopy, RefusesATargetThatIsNotEmptyAndLeavesIt) {
  ASSERT_NO_FATAL_FAILURE(fill_source());
  TokenStore tokens(to_);
  ASSERT_TRUE(tokens.insert({.name = "you", .role = "admin", .hash = hash_of_token("b")}));
  const auto refused = copy_database(from_, to_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  EXPECT_TRUE(MapStore(to_).list("", 1).value().empty());
  EXPECT_EQ(tokens.list().value().size(), 1U);
}

TEST_P(DatabaseCopy, RefusesASourceWithJobsThatAreNotFinished) {
  JobStore jobs(from_);
  ASSERT_TRUE(jobs.insert({.id = "a", .kind = "import", .map = "office", .created = "t0"}, {}));
  const auto refused = copy_database(from_, to_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  EXPECT_THAT(refused.error().message, HasSubstr("1 jobs"));
  ASSERT_TRUE(jobs.cancel("a", "t1"));
  EXPECT_TRUE(copy_database(from_, to_));
}

TEST_P(DatabaseCopy, RefusesASourceWhoseContentHasAnotherDigest) {
  ASSERT_NO_FATAL_FAILURE(fill_source());
  from_databases_.run("source", "UPDATE maps SET digest = 'abc' WHERE name = 'office'");
  const auto refused = copy_database(from_, to_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCorruptData);
  EXPECT_THAT(refused.error().message, HasSubstr("map office"));
}

}  // namespace
}  // namespace cornerfix::storage

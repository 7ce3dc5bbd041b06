#include "server/map_ranking.hpp"

#include <gmock/gmock.h>

#include "unit/server/service_fixture.hpp"

namespace cornerfix::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class MapRankingTest : public ServiceTest {
 protected:
  /// A map without content that was derived.
  static void put_plan(Process& process, const std::string& name, Cell first = Cell::kFree) {
    const OccupancyGrid plan{.resolution = 0.1,
                             .T_map_grid = {},
                             .width = 2,
                             .height = 1,
                             .cells = {first, Cell::kOccupied}};
    const auto info = process.maps->find(name);
    const storage::FloorMap stored{
        .grid = plan,
        .known = {info ? info->revision : 0},
        .outline = {.feature_count = 0, .bounds = Bounds{{0.0, 0.0}, {0.2, 0.1}}}};
    ASSERT_TRUE(process.stores->with_maps(
        [&](storage::MapStore& maps) { return maps.put_floor_map(name, stored, kNow); }));
  }

  static void store_sketch(Process& process, const std::string& name) {
    const storage::MapInfo info = process.maps->find(name).value();
    ASSERT_TRUE(process.stores->with_maps([&](storage::MapStore& maps) {
      return maps.store_sketch(info.id, info.revision, MapSketch{});
    }));
  }

  static MapRankingUse use(Process& process) {
    EXPECT_TRUE(process.ranking->refresh());
    return process.ranking->use();
  }

  std::vector<MapKey> ranked() {
    std::vector<MapKey> keys;
    for (const RankedMap& one : process_.ranking->rank({})) keys.push_back(one.key);
    return keys;
  }

  Process process_{file()};
};

TEST_F(MapRankingTest, HasNoMapWithoutContent) {
  ASSERT_TRUE(process_.maps->put("empty", {}));
  EXPECT_EQ(use(process_).maps, 0U);
  EXPECT_THAT(ranked(), IsEmpty());
}

TEST_F(MapRankingTest, ReadsTheSketchesOfLoadedMapsAndLoadsNone) {
  make_map(process_, "office");
  ASSERT_TRUE(process_.maps->load("office"));
  Process restarted(file());
  EXPECT_EQ(use(restarted).sketches, 1U);
  EXPECT_GT(restarted.ranking->free_area_m2(), 10.0);
  EXPECT_EQ(restarted.maps->cache_use().loads, 0U);
  EXPECT_EQ(restarted.ranking->find("office"), restarted.maps->find("office")->id);
}

TEST_F(MapRankingTest, ReadsManySketches) {
  for (int i = 0; i < 60; ++i) {
    put_plan(process_, "plan-" + std::to_string(i));
    store_sketch(process_, "plan-" + std::to_string(i));
  }
  EXPECT_EQ(use(process_).sketches, 60U);
}

TEST_F(MapRankingTest, TakesAMapWithoutSketchForALikelyOne) {
  put_plan(process_, "plan");
  EXPECT_EQ(use(process_).sketches, 0U);
  EXPECT_THAT(ranked(), ElementsAre(process_.maps->find("plan")->id));
  EXPECT_EQ(process_.ranking->keys(), ranked());
}

TEST_F(MapRankingTest, MakesAndStoresSketchesThatAreMissing) {
  make_map(process_, "office");
  EXPECT_FALSE(process_.ranking->make_next_sketch());  // It is not known yet.
  EXPECT_EQ(use(process_).sketches, 0U);
  EXPECT_TRUE(process_.ranking->make_next_sketch());
  EXPECT_EQ(process_.ranking->use().sketches, 1U);
  EXPECT_FALSE(process_.ranking->make_next_sketch());
  EXPECT_EQ(use(process_).sketches, 1U);
  Process restarted(file());
  EXPECT_EQ(use(restarted).sketches, 1U);
}

TEST_F(MapRankingTest, LearnsOfMapsOfAnotherProcess) {
  EXPECT_EQ(use(process_).maps, 0U);
  Process other(file());
  put_plan(other, "plan");
  store_sketch(other, "plan");
  EXPECT_EQ(use(process_).sketches, 1U);
  const std::uint64_t version = process_.ranking->version();
  put_plan(other, "plan", Cell::kUnknown);
  EXPECT_EQ(use(process_).sketches, 0U);
  EXPECT_EQ(process_.ranking->entry(process_.maps->find("plan")->id)->revision, 2U);
  EXPECT_GT(process_.ranking->version(), version);
  ASSERT_TRUE(other.maps->remove("plan"));
  EXPECT_EQ(use(process_).maps, 0U);
  EXPECT_THAT(ranked(), IsEmpty());
}

TEST_F(MapRankingTest, KeepsItsVersionWhenOnlyADescriptionChanges) {
  put_plan(process_, "plan");
  EXPECT_EQ(use(process_).maps, 1U);
  const std::uint64_t version = process_.ranking->version();
  api::PutMapRequest request;
  request.description = "another text";
  ASSERT_TRUE(process_.maps->put("plan", request));
  EXPECT_EQ(use(process_).maps, 1U);
  EXPECT_EQ(process_.ranking->version(), version);
}

TEST_F(MapRankingTest, MakesNoSketchOfAMapThatStillGrows) {
  std::chrono::steady_clock::time_point now{};
  MapRanking ranking(
      process_.stores, process_.maps,
      {.quiet_time = std::chrono::seconds(10), .now = [&] { return now; }, .has_thread = false});
  ASSERT_TRUE(ranking.refresh());
  make_map(process_, "office");
  ASSERT_TRUE(ranking.refresh());
  EXPECT_FALSE(ranking.make_next_sketch());
  now += std::chrono::seconds(9);
  ASSERT_TRUE(process_.maps->grow("office", testing::mapping_drive(1e6)));
  ASSERT_TRUE(ranking.refresh());
  now += std::chrono::seconds(9);
  EXPECT_FALSE(ranking.make_next_sketch());
  now += std::chrono::seconds(1);
  EXPECT_TRUE(ranking.make_next_sketch());
  EXPECT_EQ(ranking.use().sketches, 1U);
}

TEST_F(MapRankingTest, TriesAMapThatCannotBeMadeOnce) {
  put_plan(process_, "plan");
  EXPECT_EQ(use(process_).maps, 1U);
  ASSERT_TRUE(process_.maps->remove("plan"));
  EXPECT_TRUE(process_.ranking->make_next_sketch());
  EXPECT_FALSE(process_.ranking->make_next_sketch());
}

}  // namespace
}  // namespace cornerfix::server

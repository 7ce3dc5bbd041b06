#include "unit/storage/map_store_fixture.hpp"

#include <gmock/gmock.h>

#include <limits>

namespace cornerfix::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class MapStoreTest : public MapStoreFixture {};

INSTANTIATE_TEST_SUITE_P(Engines, MapStoreTest, ::testing::ValuesIn(engines()), EngineName());

TEST_P(MapStoreTest, CreatesAMapOnce) {
  EXPECT_TRUE(store_.put("office", "d", std::nullopt, std::nullopt, "t0").value());
  EXPECT_FALSE(store_.put("office", "d", std::nullopt, std::nullopt, "t1").value());
}

TEST_P(MapStoreTest, FindsWhatWasPut) {
  ASSERT_TRUE(store_.put("office", "floor 2", "{\"lidar\":1}", "{\"params\":2}", "t0"));
  const MapInfo map = store_.find("office").value();
  EXPECT_EQ(map.name, "office");
  EXPECT_EQ(map.description, "floor 2");
  EXPECT_EQ(map.lidar_json, "{\"lidar\":1}");
  EXPECT_EQ(map.parameters_json, "{\"params\":2}");
  EXPECT_EQ(map.created, "t0");
  EXPECT_EQ(map.updated, "t0");
  EXPECT_EQ(map.revision, 1U);
  EXPECT_EQ(map.key_frame_count, 0U);
  EXPECT_FALSE(map.bounds);
}

TEST_P(MapStoreTest, KeepsTheBytesOfAnyText) {
  using namespace std::string_literals;
  const std::string description = "zero \0 inside, \xC3\xBC, ' \" %"s;
  ASSERT_TRUE(store_.put("office", description, std::nullopt, std::nullopt, "t0"));
  EXPECT_EQ(store_.find("office")->description, description);
}

TEST_P(MapStoreTest, DoesNotFindAnUnknownMap) {
  EXPECT_EQ(store_.find("nowhere").error().code, ErrorCode::kNotFound);
}

TEST_P(MapStoreTest, KeepsPartsThatAreNotGiven) {
  ASSERT_TRUE(store_.put("office", "floor 2", "lidar", "params", "t0"));
  ASSERT_TRUE(store_.put("office", std::nullopt, std::nullopt, std::nullopt, "t1"));
  const MapInfo map = store_.find("office").value();
  EXPECT_EQ(map.description, "floor 2");
  EXPECT_EQ(map.lidar_json, "lidar");
  EXPECT_EQ(map.parameters_json, "params");
  EXPECT_EQ(map.updated, "t0");
}

TEST_P(MapStoreTest, KeepsTheRevisionWhenOnlyTheDescriptionChanges) {
  const MapInfo before = make_map();
  ASSERT_TRUE(store_.put("office", "floor 3", std::nullopt, std::nullopt, "t1"));
  const MapInfo after = store_.find("office").value();
  EXPECT_EQ(after.revision, before.revision);
  EXPECT_EQ(after.digest, before.digest);
  EXPECT_EQ(after.updated, "t1");
}

TEST_P(MapStoreTest, GivesANewRevisionToOtherParametersOrAnotherLidar) {
  const MapInfo before = make_map();
  ASSERT_TRUE(store_.put("office", std::nullopt, std::nullopt, "params", "t1"));
  ASSERT_TRUE(store_.put("office", std::nullopt, "lidar", std::nullopt, "t2"));
  EXPECT_EQ(store_.find("office")->revision, before.revision + 2);
}

TEST_P(MapStoreTest, OutlinesAMapWithOtherParametersIfItIsAtTheExpectedRevision) {
  const MapInfo map = grow(make_map(), 1);
  const auto put = [&](std::uint64_t revision) {
    return store_.put("office", "d", std::nullopt, "params", "t1",
                      MapRemake{.known = {revision}, .outline = outline_});
  };
  const std::string before = dump();
  EXPECT_EQ(put(map.revision - 1).error().code, ErrorCode::kConflict);
  EXPECT_EQ(put(0).error().code, ErrorCode::kConflict);
  EXPECT_EQ(dump(), before);
  ASSERT_TRUE(put(map.revision));
  EXPECT_EQ(store_.find("office")->feature_count, outline_.feature_count);
  EXPECT_EQ(store_.find("office")->bounds.value().max, outline_.bounds->max);
}

TEST_P(MapStoreTest, ReplacesOnlyTheDescriptionThatWasSeen) {
  const MapInfo seen = make_map();
  const MapRemake remake{.known = {seen.revision, seen.id, seen.description}};
  ASSERT_TRUE(store_.put("office", "first", std::nullopt, std::nullopt, "t1", remake));
  const auto second = store_.put("office", "second", std::nullopt, std::nullopt, "t2", remake);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kConflict);
  EXPECT_EQ(second.error().field, "revision");
  EXPECT_EQ(store_.remove("office", remake.known).error().code, ErrorCode::kConflict);
  EXPECT_EQ(store_.find("office")->description, "first");
}

TEST_P(MapStoreTest, LeavesAnotherMapOfTheSameNameAndRevisionAsItIs) {
  const MapInfo seen = make_map();
  ASSERT_TRUE(store_.remove("office"));
  const MapInfo other = make_map();
  ASSERT_EQ(other.revision, seen.revision);
  const KnownMap known{seen.revision, seen.id};
  const OccupancyGrid plan{
      .resolution = 0.1, .T_map_grid = {}, .width = 1, .height = 1, .cells = {Cell::kFree}};
  const std::string before = dump();
  EXPECT_EQ(store_.put("office", "d", std::nullopt, "params", "t1", MapRemake{known}).error().code,
            ErrorCode::kConflict);
  EXPECT_EQ(store_.put_floor_map("office", {.grid = plan, .known = known}, "t1").error().code,
            ErrorCode::kConflict);
  EXPECT_EQ(store_.remove("office", known).error().code, ErrorCode::kConflict);
  EXPECT_EQ(dump(), before);
}

TEST_P(MapStoreTest, OutlinesNoMapWithoutContent) {
  ASSERT_TRUE(store_.put("office", std::nullopt, std::nullopt, "params", "t0",
                         MapRemake{.outline = outline_}));
  EXPECT_EQ(store_.find("office")->feature_count, 0U);
  EXPECT_FALSE(store_.find("office")->bounds);
}

TEST_P(MapStoreTest, KeepsTheRevisionWhenTheSameIsPutAgain) {
  ASSERT_TRUE(store_.put("office", "d", "lidar", "params", "t0"));
  ASSERT_TRUE(store_.put("office", "d", "lidar", "params", "t1"));
  EXPECT_EQ(store_.find("office")->revision, 1U);
  EXPECT_EQ(store_.find("office")->updated, "t0");
}

TEST_P(MapStoreTest, ListsByNameInPages) {
  for (const std::string name : {"b", "d", "a", "c", "B"}) make_map(name);
  const auto names = [&](const std::string& after, std::size_t limit) {
    std::vector<std::string> found;
    const std::vector<MapInfo> maps = store_.list(after, limit).value();
    for (const MapInfo& map : maps) found.push_back(map.name);
    return found;
  };
  EXPECT_THAT(names("", 3), ElementsAre("B", "a", "b"));
  EXPECT_THAT(names("b", 3), ElementsAre("c", "d"));
  EXPECT_THAT(names("d", 3), IsEmpty());
  EXPECT_THAT(names("", std::numeric_limits<std::size_t>::max()), SizeIs(5));
}

TEST_P(MapStoreTest, DeletesAllOfAMapAndNothingElse) {
  const MapInfo office = grow(make_map("office"), 3);
  const MapInfo lab = grow(make_map("lab"), 4);
  ASSERT_TRUE(store_.store_content(office.id, office.revision, sample_content(3)));
  ASSERT_TRUE(store_.store_content(lab.id, lab.revision, sample_content(3)));
  ASSERT_TRUE(store_.remove("office"));
  EXPECT_EQ(count("maps"), 1);
  EXPECT_EQ(count("key_frames"), 4);
  EXPECT_EQ(count("map_stamps"), 4);
  EXPECT_EQ(count("map_contents"), 1);
  EXPECT_EQ(store_.key_frames(office.id).error().code, ErrorCode::kNotFound);
  EXPECT_THAT(store_.key_frames(lab.id).value(), SizeIs(4));
}

TEST_P(MapStoreTest, DoesNotDeleteAnUnknownMap) {
  EXPECT_EQ(store_.remove("nowhere").error().code, ErrorCode::kNotFound);
}

TEST_P(MapStoreTest, NeverGivesTheIdOfADeletedMapToAnother) {
  const MapInfo first = make_map();
  ASSERT_TRUE(store_.remove("office"));
  EXPECT_NE(make_map().id, first.id);
}

}  // namespace
}  // namespace cornerfix::storage

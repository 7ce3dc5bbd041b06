#include "unit/storage/map_store_fixture.hpp"

#include <gmock/gmock.h>

#include "storage/blob_codec.hpp"

namespace cornerfix::storage {
namespace {

class MapContentTest : public MapStoreFixture {};

INSTANTIATE_TEST_SUITE_P(Engines, MapContentTest, ::testing::ValuesIn(engines()), EngineName());

TEST_P(MapContentTest, GivesBackContentBitForBit) {
  const MapInfo map = grow(make_map(), 2);
  const MapContent content = sample_content(8);
  ASSERT_TRUE(store_.store_content(map.id, map.revision, content));
  const auto stored = store_.content(map.id).value();
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->revision, map.revision);
  EXPECT_TRUE(is_same(stored->content, content));
  EXPECT_EQ(store_.find("office")->feature_count, 8U);
  EXPECT_EQ(store_.find("office")->revision, map.revision);
}

TEST_P(MapContentTest, GivesBackTheDescriptorsOfALargeMapWithoutStoringThem) {
  const MapInfo map = make_map();
  MapContent content = sample_content(2100);
  for (Feature& feature : content.features) feature.position.x() *= 0.1;
  content.descriptors = describe(content.features, content.descriptors.params);
  ASSERT_GT(content.descriptors.entries.size(), std::size_t{4} << 20U);
  ASSERT_TRUE(store_.store_content(map.id, map.revision, content));
  EXPECT_TRUE(is_same(store_.content(map.id).value()->content, content));
}

TEST_P(MapContentTest, GivesBackContentWithoutFeatures) {
  const MapInfo map = make_map();
  ASSERT_TRUE(store_.store_content(map.id, map.revision, MapContent{}));
  EXPECT_TRUE(is_same(store_.content(map.id).value()->content, MapContent{}));
}

TEST_P(MapContentTest, HasNoContentAtFirst) { EXPECT_FALSE(store_.content(make_map().id).value()); }

TEST_P(MapContentTest, KeepsOlderContentWithItsRevisionWhenTheMapGrows) {
  const MapInfo map = grow(make_map(), 2);
  ASSERT_TRUE(store_.store_content(map.id, map.revision, sample_content(3)));
  grow(map, 1);
  EXPECT_EQ(store_.content(map.id).value()->revision, map.revision);
}

TEST_P(MapContentTest, IgnoresContentOfARevisionThatHasPassed) {
  const MapInfo map = grow(make_map(), 2);
  const MapInfo newer = grow(map, 1);
  ASSERT_TRUE(store_.store_content(newer.id, newer.revision, sample_content(5)));
  ASSERT_TRUE(store_.store_content(map.id, map.revision, sample_content(3)));
  EXPECT_EQ(store_.content(map.id).value()->revision, newer.revision);
  EXPECT_EQ(store_.find("office")->feature_count, 5U);
}

TEST_P(MapContentTest, RefusesFeaturesAndDescriptorsThatDoNotBelongTogether) {
  const MapInfo map = make_map();
  ASSERT_TRUE(store_.store_content(map.id, map.revision, sample_content(3)));
  const Blob features = encode_features(sample_content(2).features);
  databases_.run("maps", "UPDATE map_contents SET features = " + databases_.literal(features));
  EXPECT_EQ(store_.content(map.id).error().code, ErrorCode::kCorruptData);
}

OccupancyGrid small_plan(Cell first) {
  OccupancyGrid grid{
      .resolution = 0.1, .T_map_grid = {1, 2, 3}, .width = 2, .height = 1, .cells = {}};
  grid.cells = {first, Cell::kOccupied};
  return grid;
}

TEST_P(MapContentTest, MakesAMapOfAFloorMapAndReplacesIt) {
  const OccupancyGrid plan = small_plan(Cell::kFree);
  const MapInfo put =
      store_.put_floor_map("plan", {.grid = plan, .outline = {.feature_count = 4}}, "t1").value();
  const MapInfo first = store_.find("plan").value();
  EXPECT_EQ(put.digest, first.digest);
  EXPECT_EQ(put.id, first.id);
  EXPECT_TRUE(first.has_floor_map);
  EXPECT_EQ(first.revision, 1U);
  EXPECT_EQ(first.feature_count, 4U);
  EXPECT_EQ(store_.floor_map(first.id).value(), plan);

  const OccupancyGrid other = small_plan(Cell::kUnknown);
  ASSERT_TRUE(store_.put_floor_map("plan", {.grid = other, .known = {1}}, "t2"));
  const MapInfo second = store_.find("plan").value();
  EXPECT_EQ(second.revision, 2U);
  EXPECT_NE(second.digest, first.digest);
  EXPECT_EQ(store_.floor_map(second.id).value(), other);
}

TEST_P(MapContentTest, TheSameFloorMapAgainChangesNothing) {
  const OccupancyGrid plan = small_plan(Cell::kFree);
  ASSERT_TRUE(store_.put_floor_map("plan", {.grid = plan}, "t1"));
  const std::string before = dump();
  EXPECT_EQ(store_.put_floor_map("plan", {.grid = plan, .known = {1}}, "t2").value().revision, 1U);
  EXPECT_EQ(dump(), before);
}

TEST_P(MapContentTest, AFloorMapIsPutInTheMapThatItWasMadeForOnly) {
  const OccupancyGrid plan = small_plan(Cell::kFree);
  EXPECT_EQ(store_.put_floor_map("plan", {.grid = plan, .known = {1}}, "t1").error().code,
            ErrorCode::kConflict);
  ASSERT_TRUE(store_.put_floor_map("plan", {.grid = plan}, "t1"));
  const std::string before = dump();
  EXPECT_EQ(store_.put_floor_map("plan", {.grid = plan}, "t2").error().code, ErrorCode::kConflict);
  EXPECT_EQ(dump(), before);
}

TEST_P(MapContentTest, AFloorMapAndScansExcludeEachOther) {
  const OccupancyGrid plan = small_plan(Cell::kFree);
  grow(make_map(), 2);
  ASSERT_TRUE(store_.put_floor_map("plan", {.grid = plan}, "t1"));
  const std::string before = dump();
  EXPECT_EQ(store_.put_floor_map("office", {.grid = plan}, "t2").error().code,
            ErrorCode::kConflict);
  const MapInfo map = store_.find("plan").value();
  EXPECT_EQ(store_.grow(map.id, map.revision, growth({}, {}), "t2").error().code,
            ErrorCode::kConflict);
  EXPECT_EQ(dump(), before);
}

TEST_P(MapContentTest, AFloorMapGoesWithItsMap) {
  ASSERT_TRUE(store_.put_floor_map("plan", {.grid = small_plan(Cell::kFree)}, "t1"));
  ASSERT_TRUE(store_.remove("plan"));
  EXPECT_EQ(count("map_grids"), 0);
}

}  // namespace
}  // namespace cornerfix::storage

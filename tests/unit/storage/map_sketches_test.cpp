#include "unit/storage/map_store_fixture.hpp"

#include <gmock/gmock.h>

#include "storage/blob_codec.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::IsEmpty;

class MapSketches : public MapStoreFixture {
 protected:
  SketchState state_of(const MapInfo& map) {
    const std::vector<SketchState> states = store_.sketch_states().value();
    for (const SketchState& state : states) {
      if (state.id == map.id) return state;
    }
    ADD_FAILURE() << map.name << " has no state";
    return {};
  }
};

INSTANTIATE_TEST_SUITE_P(Engines, MapSketches, ::testing::ValuesIn(engines()), EngineName());

TEST_P(MapSketches, AreGivenBackBitForBit) {
  const MapInfo map = grow(make_map(), 2);
  ASSERT_TRUE(store_.store_sketch(map.id, map.revision, sample_sketch(3)));
  const SketchPage page = store_.sketches(0, 10).value();
  ASSERT_EQ(page.sketches.size(), 1U);
  EXPECT_EQ(page.sketches[0].map_id, map.id);
  EXPECT_EQ(page.sketches[0].revision, map.revision);
  EXPECT_EQ(page.sketches[0].sketch, sample_sketch(3));
  EXPECT_FALSE(page.next);
  EXPECT_EQ(store_.find("office")->revision, map.revision);
}

TEST_P(MapSketches, StateTheRevisionThatTheyWereMadeFrom) {
  const MapInfo empty = make_map("empty");
  const MapInfo map = grow(make_map(), 2);
  EXPECT_FALSE(state_of(empty).has_content);
  EXPECT_TRUE(state_of(map).has_content);
  EXPECT_EQ(state_of(map).name, "office");
  EXPECT_EQ(state_of(map).sketch_revision, 0U);
  ASSERT_TRUE(store_.store_sketch(map.id, map.revision, sample_sketch(1)));
  EXPECT_EQ(state_of(map).sketch_revision, map.revision);
  const MapInfo newer = grow(map, 1);
  EXPECT_EQ(state_of(newer).revision, newer.revision);
  EXPECT_EQ(state_of(newer).sketch_revision, map.revision);
}

TEST_P(MapSketches, OfARevisionThatHasPassedAreIgnored) {
  const MapInfo map = grow(make_map(), 2);
  const MapInfo newer = grow(map, 1);
  ASSERT_TRUE(store_.store_sketch(newer.id, newer.revision, sample_sketch(2)));
  ASSERT_TRUE(store_.store_sketch(map.id, map.revision, sample_sketch(1)));
  EXPECT_EQ(state_of(map).sketch_revision, newer.revision);
  EXPECT_EQ(store_.sketches(0, 10)->sketches[0].sketch, sample_sketch(2));
}

TEST_P(MapSketches, OfADeletedMapAreIgnored) {
  const MapInfo map = make_map();
  ASSERT_TRUE(store_.store_sketch(map.id, map.revision, sample_sketch(1)));
  ASSERT_TRUE(store_.remove("office"));
  EXPECT_EQ(count("map_sketches"), 0);
  ASSERT_TRUE(store_.store_sketch(map.id, map.revision, sample_sketch(1)));
  EXPECT_EQ(count("map_sketches"), 0);
  EXPECT_THAT(store_.sketch_states().value(), IsEmpty());
}

TEST_P(MapSketches, ComeInPages) {
  std::vector<std::int64_t> expected;
  for (const std::string name : {"c", "a", "b", "d", "e"}) {
    const MapInfo map = make_map(name);
    expected.push_back(map.id);
    ASSERT_TRUE(store_.store_sketch(map.id, map.revision, sample_sketch(1)));
  }
  std::vector<std::int64_t> found;
  for (std::optional<std::int64_t> after = 0; after;) {
    const SketchPage page = store_.sketches(*after, 2).value();
    for (const StoredSketch& one : page.sketches) found.push_back(one.map_id);
    after = page.next;
  }
  EXPECT_EQ(found, expected);
}

TEST_P(MapSketches, ThatAreDamagedAreLeftOut) {
  const MapInfo map = make_map();
  ASSERT_TRUE(store_.store_sketch(map.id, map.revision, sample_sketch(1)));
  Blob blob = encode_map_sketch(sample_sketch(1));
  blob[20] ^= 1U;
  databases_.run("maps", "UPDATE map_sketches SET sketch = " + databases_.literal(blob));
  const SketchPage page = store_.sketches(0, 1).value();
  EXPECT_THAT(page.sketches, IsEmpty());
  EXPECT_EQ(page.next, map.id);
}

}  // namespace
}  // namespace cornerfix::storage

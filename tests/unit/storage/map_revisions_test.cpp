#include "storage/map_revisions.hpp"

#include <gmock/gmock.h>

#include "unit/storage/map_store_fixture.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::ElementsAre;

class MapRevisionsTest : public MapStoreFixture {
 protected:
  std::vector<std::uint64_t> numbers(MapStore& store) {
    const std::vector<MapRevision> revisions = store.revisions("office").value();
    std::vector<std::uint64_t> numbers;
    for (const MapRevision& revision : revisions) numbers.push_back(revision.revision);
    return numbers;
  }
  std::vector<std::uint64_t> numbers() { return numbers(store_); }
  MapInfo put_parameters(MapStore& store, std::string_view json) {
    EXPECT_TRUE(store.put("office", std::nullopt, std::nullopt, json, "t5"));
    return store.find("office").value();
  }
  MapArchive archive_of(std::uint64_t revision) {
    return decode_archive(store_.revision_archive("office", revision).value()).value();
  }
};

INSTANTIATE_TEST_SUITE_P(Engines, MapRevisionsTest, ::testing::ValuesIn(engines()), EngineName());

TEST_P(MapRevisionsTest, KeepsTheRevisionBeforeOtherSettings) {
  const MapInfo before = grow(make_map(), 3);
  const MapInfo after = put_parameters(store_, "{\"a\":1}");
  const std::vector<MapRevision> revisions = store_.revisions("office").value();
  ASSERT_EQ(revisions.size(), 2U);
  EXPECT_EQ(revisions[0].revision, after.revision);
  EXPECT_EQ(revisions[0].digest, after.digest);
  EXPECT_EQ(revisions[0].origin, RevisionOrigin::kSettings);
  EXPECT_EQ(revisions[0].archive_bytes, 0U);
  EXPECT_EQ(revisions[1].revision, before.revision);
  EXPECT_EQ(revisions[1].digest, before.digest);
  EXPECT_EQ(revisions[1].created, "t1");
  EXPECT_EQ(revisions[1].origin, RevisionOrigin::kScans);
  EXPECT_EQ(revisions[1].feature_count, before.feature_count);
  EXPECT_EQ(revisions[1].archive_bytes, store_.revision_archive("office", before.revision)->size());
}

TEST_P(MapRevisionsTest, KeepsOneRevisionPerMappingRun) {
  const MapInfo first = grow(make_map(), 2, "2024-05-01T12:00:00Z");
  const MapInfo second = grow(first, 2, "2024-05-01T12:09:59Z");
  EXPECT_THAT(numbers(), ElementsAre(second.revision));
  const MapInfo next_run = grow(second, 2, "2024-05-01T12:19:59Z");
  const MapInfo within = grow(next_run, 2, "2024-05-01T12:20:00Z");
  EXPECT_THAT(numbers(), ElementsAre(within.revision, second.revision));
  EXPECT_EQ(archive_of(second.revision).key_frames.size(), 4U);
}

TEST_P(MapRevisionsTest, KeepsTheNewestOnly) {
  MapStore two(database_, 2);
  const MapInfo grown = grow(make_map(), 2);
  for (const char* json : {"1", "2", "3"}) put_parameters(two, json);
  const std::uint64_t last = grown.revision + 3;
  EXPECT_THAT(numbers(two), ElementsAre(last, last - 1, last - 2));
  MapStore none(database_, 0);
  put_parameters(none, "4");
  EXPECT_THAT(numbers(none), ElementsAre(last + 1));
}

TEST_P(MapRevisionsTest, KeepsNoMapWithoutContent) {
  make_map();
  const MapInfo after = put_parameters(store_, "1");
  EXPECT_THAT(numbers(), ElementsAre(after.revision));
}

TEST_P(MapRevisionsTest, RollsBackToKeyFramesStampsAndParameters) {
  const MapInfo before = grow(make_map(), 3);
  const MapArchive source = store_.archive("office").value();
  MapInfo now = grow(put_parameters(store_, "{\"a\":1}"), 2, "t6");
  now = store_
            .roll_back(now.id, now.revision, archive_of(before.revision),
                       {.feature_count = 12, .bounds = before.bounds}, "t7")
            .value();
  EXPECT_EQ(now.revision, before.revision + 3);
  EXPECT_EQ(now.digest, before.digest);
  EXPECT_EQ(now.revision_origin, RevisionOrigin::kRollBack);
  const MapInfo found = store_.find("office").value();
  EXPECT_EQ(found.revision, now.revision);
  EXPECT_EQ(found.digest, before.digest);
  EXPECT_EQ(found.key_frame_count, 3U);
  EXPECT_EQ(found.parameters_json, "");
  const MapArchive rolled = store_.archive("office").value();
  EXPECT_TRUE(is_same(rolled.key_frames, source.key_frames));
  EXPECT_EQ(rolled.stamps, source.stamps);
  // The revision that was rolled back is kept, so that the roll-back can be undone.
  EXPECT_EQ(archive_of(before.revision + 2).key_frames.size(), 5U);
}

TEST_P(MapRevisionsTest, RollsBackToAnOccupancyMap) {
  OccupancyGrid plan = sample_content(1).grid;
  const MapInfo first = store_.put_floor_map("office", {.grid = plan}, "t1").value();
  plan.cells[0] = plan.cells[0] == Cell::kFree ? Cell::kOccupied : Cell::kFree;
  const MapInfo second =
      store_.put_floor_map("office", {.grid = plan, .known = {first.revision}}, "t2").value();
  ASSERT_NE(second.digest, first.digest);
  ASSERT_TRUE(store_.roll_back(second.id, second.revision, archive_of(first.revision), {}, "t3"));
  EXPECT_EQ(store_.find("office")->digest, first.digest);
  EXPECT_EQ(store_.floor_map(first.id).value(), sample_content(1).grid);
}

TEST_P(MapRevisionsTest, RefusesToRollBackAnotherRevision) {
  const MapInfo before = grow(make_map(), 3);
  const MapInfo now = put_parameters(store_, "1");
  const std::string dumped = dump();
  const auto late =
      store_.roll_back(now.id, before.revision, archive_of(before.revision), {}, "t7");
  EXPECT_EQ(late.error().code, ErrorCode::kConflict);
  EXPECT_EQ(dump(), dumped);
}

TEST_P(MapRevisionsTest, NamesTheRevisionsThatThereAre) {
  grow(make_map(), 3);
  put_parameters(store_, "1");
  const Error error = store_.revision_archive("office", 99).error();
  EXPECT_EQ(error.code, ErrorCode::kNotFound);
  EXPECT_EQ(error.message, "the map 'office' has no revision 99; it has 3, 2");
  EXPECT_EQ(store_.revisions("lab").error().code, ErrorCode::kNotFound);
}

TEST_P(MapRevisionsTest, GoWithTheirMap) {
  grow(make_map(), 3);
  put_parameters(store_, "1");
  ASSERT_EQ(count("map_revisions"), 1);
  ASSERT_TRUE(store_.remove("office"));
  EXPECT_EQ(count("map_revisions"), 0);
}

TEST(MapRevisions, AreApartByTheSecondsBetweenTheirTimes) {
  EXPECT_EQ(seconds_between("2024-02-28T23:59:59Z", "2024-03-01T00:00:00Z"), 86'401);
  EXPECT_EQ(seconds_between("t0", "2024-03-01T00:00:00Z"), std::nullopt);
  EXPECT_EQ(seconds_between("2024-02-30T00:00:00Z", "2024-03-01T00:00:00Z"), std::nullopt);
}

TEST(MapRevisions, HaveOriginsWithNames) {
  for (const auto origin : {RevisionOrigin::kUnknown, RevisionOrigin::kScans,
                            RevisionOrigin::kOccupancyMap, RevisionOrigin::kRollBack})
    EXPECT_EQ(revision_origin_from(to_string(origin)), origin);
  EXPECT_EQ(revision_origin_from("of a newer program"), RevisionOrigin::kUnknown);
}

}  // namespace
}  // namespace cornerfix::storage

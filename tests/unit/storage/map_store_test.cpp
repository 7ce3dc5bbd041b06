#include "storage/map_store.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include <limits>
#include <thread>

#include "storage/blob_codec.hpp"
#include "storage/database.hpp"
#include "unit/storage/storage_samples.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class MapStoreTest : public ::testing::Test {
 protected:
  const MapOutline outline_{.feature_count = 7, .bounds = Bounds{{11.0, 20.0}, {13.0, 23.0}}};

  MapInfo make_map(const std::string& name = "office") {
    EXPECT_TRUE(store_.put(name, std::nullopt, std::nullopt, std::nullopt, "t0").value());
    return store_.find(name).value();
  }
  /// Adds `count` keyframes with their stamps.
  MapInfo grow(const MapInfo& map, int count, const std::string& now = "t1") {
    return grow(map, sample_key_frames(count), now);
  }
  MapInfo grow(const MapInfo& map, const std::vector<PosedScan>& key_frames,
               const std::string& now = "t1") {
    std::vector<double> stamps;
    for (const PosedScan& key_frame : key_frames) {
      stamps.push_back(key_frame.scan.stamp + static_cast<double>(map.key_frame_count) * 1000.0);
    }
    return store_.grow(map.id, map.revision, growth(stamps, key_frames), now).value();
  }
  static MapGrowth growth(std::span<const double> stamps, std::span<const PosedScan> key_frames) {
    return {.stamps = stamps,
            .new_key_frames = key_frames,
            .outline = {.feature_count = 12, .bounds = Bounds{{-1.0, -2.0}, {3.5, 4.5}}}};
  }
  /// A number out of the file.
  std::int64_t count(const std::string& table) {
    return database_->connection().execAndGet("SELECT count(*) FROM " + table).getInt64();
  }
  /// All of a store that a caller can see, to compare before with after.
  std::string dump() {
    std::string text;
    const std::vector<MapInfo> maps = store_.list("", 100).value();
    for (const MapInfo& map : maps) {
      text += map.name + " " + std::to_string(map.revision) + " " + map.digest + " " + map.updated;
      text += " " + std::to_string(map.key_frame_count) + " " + std::to_string(map.feature_count);
    }
    for (const char* table : {"maps", "key_frames", "map_stamps", "map_contents"}) {
      text += " " + std::to_string(count(table));
    }
    return text;
  }

  TempDirectory directory_;
  std::shared_ptr<Database> database_ = open_database(directory_ / "maps.db");
  MapStore store_{database_};
};

TEST_F(MapStoreTest, CreatesAMapOnce) {
  EXPECT_TRUE(store_.put("office", "d", std::nullopt, std::nullopt, "t0").value());
  EXPECT_FALSE(store_.put("office", "d", std::nullopt, std::nullopt, "t1").value());
}

TEST_F(MapStoreTest, FindsWhatWasPut) {
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

TEST_F(MapStoreTest, KeepsTheBytesOfAnyText) {
  using namespace std::string_literals;
  const std::string description = "zero \0 inside, \xC3\xBC, ' \" %"s;
  ASSERT_TRUE(store_.put("office", description, std::nullopt, std::nullopt, "t0"));
  EXPECT_EQ(store_.find("office")->description, description);
}

TEST_F(MapStoreTest, DoesNotFindAnUnknownMap) {
  EXPECT_EQ(store_.find("nowhere").error().code, ErrorCode::kNotFound);
}

TEST_F(MapStoreTest, KeepsPartsThatAreNotGiven) {
  ASSERT_TRUE(store_.put("office", "floor 2", "lidar", "params", "t0"));
  ASSERT_TRUE(store_.put("office", std::nullopt, std::nullopt, std::nullopt, "t1"));
  const MapInfo map = store_.find("office").value();
  EXPECT_EQ(map.description, "floor 2");
  EXPECT_EQ(map.lidar_json, "lidar");
  EXPECT_EQ(map.parameters_json, "params");
  EXPECT_EQ(map.updated, "t0");
}

TEST_F(MapStoreTest, KeepsTheRevisionWhenOnlyTheDescriptionChanges) {
  const MapInfo before = make_map();
  ASSERT_TRUE(store_.put("office", "floor 3", std::nullopt, std::nullopt, "t1"));
  const MapInfo after = store_.find("office").value();
  EXPECT_EQ(after.revision, before.revision);
  EXPECT_EQ(after.digest, before.digest);
  EXPECT_EQ(after.updated, "t1");
}

TEST_F(MapStoreTest, GivesANewRevisionToOtherParametersOrAnotherLidar) {
  const MapInfo before = make_map();
  ASSERT_TRUE(store_.put("office", std::nullopt, std::nullopt, "params", "t1"));
  ASSERT_TRUE(store_.put("office", std::nullopt, "lidar", std::nullopt, "t2"));
  EXPECT_EQ(store_.find("office")->revision, before.revision + 2);
}

TEST_F(MapStoreTest, OutlinesAMapWithOtherParametersIfItIsAtTheExpectedRevision) {
  const MapInfo map = grow(make_map(), 1);
  const auto put = [&](std::uint64_t revision) {
    return store_.put("office", "d", std::nullopt, "params", "t1",
                      MapRemake{.expected_revision = revision, .outline = outline_});
  };
  const std::string before = dump();
  EXPECT_EQ(put(map.revision - 1).error().code, ErrorCode::kConflict);
  EXPECT_EQ(put(0).error().code, ErrorCode::kConflict);
  EXPECT_EQ(dump(), before);
  ASSERT_TRUE(put(map.revision));
  EXPECT_EQ(store_.find("office")->feature_count, outline_.feature_count);
  EXPECT_EQ(store_.find("office")->bounds.value().max, outline_.bounds->max);
}

TEST_F(MapStoreTest, OutlinesNoMapWithoutContent) {
  ASSERT_TRUE(store_.put("office", std::nullopt, std::nullopt, "params", "t0",
                         MapRemake{.expected_revision = 0, .outline = outline_}));
  EXPECT_EQ(store_.find("office")->feature_count, 0U);
  EXPECT_FALSE(store_.find("office")->bounds);
}

TEST_F(MapStoreTest, KeepsTheRevisionWhenTheSameIsPutAgain) {
  ASSERT_TRUE(store_.put("office", "d", "lidar", "params", "t0"));
  ASSERT_TRUE(store_.put("office", "d", "lidar", "params", "t1"));
  EXPECT_EQ(store_.find("office")->revision, 1U);
  EXPECT_EQ(store_.find("office")->updated, "t0");
}

TEST_F(MapStoreTest, ListsByNameInPages) {
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

TEST_F(MapStoreTest, GivesBackKeyFramesBitForBit) {
  const MapInfo map = make_map();
  const std::vector<PosedScan> key_frames = sample_key_frames(25);
  grow(map, key_frames);
  EXPECT_TRUE(is_same(store_.key_frames(map.id).value(), key_frames));
}

TEST_F(MapStoreTest, AppendsKeyFramesInOrder) {
  const MapInfo map = make_map();
  const std::vector<PosedScan> key_frames = sample_key_frames(10);
  MapInfo grown = grow(map, {key_frames.begin(), key_frames.begin() + 4});
  grow(grown, {key_frames.begin() + 4, key_frames.end()});
  EXPECT_TRUE(is_same(store_.key_frames(map.id).value(), key_frames));
}

TEST_F(MapStoreTest, ReturnsTheEntryThatItStoredAfterGrowth) {
  const MapInfo map = make_map();
  const MapInfo grown = grow(map, 5, "t7");
  const MapInfo found = store_.find("office").value();
  EXPECT_EQ(grown.revision, map.revision + 1);
  EXPECT_EQ(found.revision, grown.revision);
  EXPECT_EQ(found.digest, grown.digest);
  EXPECT_EQ(found.key_frame_count, 5U);
  EXPECT_EQ(found.feature_count, 12U);
  EXPECT_EQ(found.updated, "t7");
  EXPECT_EQ(found.created, "t0");
  ASSERT_TRUE(found.bounds);
  EXPECT_EQ(found.bounds->min, Point2(-1.0, -2.0));
  EXPECT_EQ(found.bounds->max, Point2(3.5, 4.5));
}

TEST_F(MapStoreTest, KeepsTheRevisionWhenAGrowthBringsNoKeyFrame) {
  const MapInfo before = grow(make_map(), 3);
  const std::vector<double> stamps = {77.0};
  const MapInfo after = store_.grow(before.id, before.revision, growth(stamps, {}), "t2").value();
  EXPECT_EQ(after.revision, before.revision);
  EXPECT_EQ(after.digest, before.digest);
  EXPECT_THAT(store_.known_stamps(before.id, stamps).value(), ElementsAre(true));
}

TEST_F(MapStoreTest, HasNoBoundsWithoutKeyFrames) {
  const MapInfo map = make_map();
  const std::vector<double> stamps = {1.0};
  EXPECT_FALSE(store_.grow(map.id, map.revision, growth(stamps, {}), "t1")->bounds);
  EXPECT_FALSE(store_.find("office")->bounds);
}

TEST_F(MapStoreTest, KnowsTheStampsOfTheMapOnly) {
  const MapInfo office = make_map("office");
  const MapInfo lab = make_map("lab");
  const std::vector<double> stamps = {1.5, 0.0, 1e9 + 1e-6};
  ASSERT_TRUE(store_.grow(office.id, office.revision, growth(stamps, {}), "t1"));
  const std::vector<double> asked = {1e9 + 1e-6, 2.5, 1.5, -0.0};
  EXPECT_THAT(store_.known_stamps(office.id, asked).value(), ElementsAre(true, false, true, true));
  EXPECT_THAT(store_.known_stamps(lab.id, asked).value(), ElementsAre(false, false, false, false));
}

TEST_F(MapStoreTest, RefusesGrowthFromAnotherRevision) {
  const MapInfo map = make_map();
  grow(map, 2);
  const std::string before = dump();
  const std::vector<PosedScan> key_frames = sample_key_frames(1);
  const auto late = store_.grow(map.id, map.revision, growth({}, key_frames), "t9");
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kConflict);
  EXPECT_EQ(dump(), before);
}

TEST_F(MapStoreTest, RefusesGrowthOfADeletedMap) {
  const MapInfo map = make_map();
  ASSERT_TRUE(store_.remove("office"));
  EXPECT_EQ(store_.grow(map.id, map.revision, growth({}, {}), "t1").error().code,
            ErrorCode::kNotFound);
}

TEST_F(MapStoreTest, LeavesNothingOfAGrowthThatFails) {
  const MapInfo map = grow(make_map(), 2);
  const std::string before = dump();
  const std::vector<PosedScan> key_frames = sample_key_frames(3);
  const std::vector<double> repeated = {500.0, 501.0, 500.0};
  const std::vector<double> not_a_stamp = {600.0, std::numeric_limits<double>::quiet_NaN()};
  for (const auto& [stamps, code] :
       {std::pair(repeated, ErrorCode::kConflict), std::pair(not_a_stamp, ErrorCode::kInternal)}) {
    const auto failed = store_.grow(map.id, map.revision, growth(stamps, key_frames), "t9");
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, code);
    EXPECT_EQ(dump(), before);
  }
  EXPECT_TRUE(store_.grow(map.id, map.revision, growth({}, key_frames), "t9"));
}

TEST_F(MapStoreTest, LeavesNothingOfAGrowthThatTheDiskCannotHold) {
  const MapInfo map = grow(make_map(), 2);
  const std::string before = dump();
  const auto pages = database_->connection().execAndGet("PRAGMA page_count").getInt();
  database_->connection().exec("PRAGMA max_page_count = " + std::to_string(pages + 5));
  const std::vector<PosedScan> key_frames = sample_key_frames(500);
  const auto failed = store_.grow(map.id, map.revision, growth({}, key_frames), "t9");
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kStorageFull);
  EXPECT_EQ(dump(), before);
  EXPECT_THAT(store_.key_frames(map.id).value(), SizeIs(2));
}

TEST_F(MapStoreTest, DeletesAllOfAMapAndNothingElse) {
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

TEST_F(MapStoreTest, DoesNotDeleteAnUnknownMap) {
  EXPECT_EQ(store_.remove("nowhere").error().code, ErrorCode::kNotFound);
}

TEST_F(MapStoreTest, NeverGivesTheIdOfADeletedMapToAnother) {
  const MapInfo first = make_map();
  ASSERT_TRUE(store_.remove("office"));
  EXPECT_NE(make_map().id, first.id);
}

TEST_F(MapStoreTest, MovesEveryKeyFrameAndNothingElseOfIt) {
  const std::vector<PosedScan> key_frames = sample_key_frames(4);
  const MapInfo map = grow(make_map(), key_frames);
  std::vector<PosedScan> expected = key_frames;
  std::vector<Pose2> poses;
  for (PosedScan& key_frame : expected) {
    key_frame.T_map_base_link = {10.0 + static_cast<double>(poses.size()), -0.0, 1.0};
    poses.push_back(key_frame.T_map_base_link);
  }
  const MapInfo moved = store_.move_key_frames(map.id, map.revision, poses, outline_, "t5").value();
  EXPECT_TRUE(is_same(store_.key_frames(map.id).value(), expected));
  EXPECT_EQ(moved.revision, map.revision + 1);
  EXPECT_EQ(moved.updated, "t5");
  EXPECT_NE(moved.digest, map.digest);
  EXPECT_EQ(store_.find("office")->digest, moved.digest);
}

TEST_F(MapStoreTest, OutlinesAMovedMapAsToldAndLeavesAnEmptyOneWithoutBounds) {
  const MapInfo map = grow(make_map(), 1);
  const std::vector<Pose2> poses = {{10.0, 20.0, 0.0}};
  ASSERT_TRUE(store_.move_key_frames(map.id, map.revision, poses, outline_, "t5"));
  const MapInfo moved = store_.find("office").value();
  EXPECT_EQ(moved.feature_count, outline_.feature_count);
  ASSERT_TRUE(moved.bounds);
  EXPECT_EQ(moved.bounds->min, outline_.bounds->min);
  EXPECT_EQ(moved.bounds->max, outline_.bounds->max);
  const MapInfo empty = make_map("empty");
  const auto unmoved = store_.move_key_frames(empty.id, empty.revision, {}, outline_, "t5");
  EXPECT_FALSE(unmoved->bounds);
}

TEST_F(MapStoreTest, KeepsTheRevisionWhenNothingMoves) {
  const std::vector<PosedScan> key_frames = sample_key_frames(2);
  const MapInfo map = grow(make_map(), key_frames);
  const std::vector<Pose2> poses = {key_frames[0].T_map_base_link, key_frames[1].T_map_base_link};
  EXPECT_EQ(store_.move_key_frames(map.id, map.revision, poses, outline_, "t5")->revision,
            map.revision);
}

TEST_F(MapStoreTest, RefusesATrajectoryOfAnotherLengthOrRevision) {
  const MapInfo map = grow(make_map(), 3);
  const std::string before = dump();
  const std::vector<Pose2> poses(3, Pose2{1.0, 2.0, 3.0});
  EXPECT_EQ(store_.move_key_frames(map.id, map.revision, std::span(poses).first(2), outline_, "t5")
                .error()
                .code,
            ErrorCode::kInvalidArgument);
  EXPECT_EQ(store_.move_key_frames(map.id, map.revision + 1, poses, outline_, "t5").error().code,
            ErrorCode::kConflict);
  EXPECT_EQ(dump(), before);
}

TEST_F(MapStoreTest, HasTheSameDigestForTheSameContentInAnotherDatabase) {
  const std::vector<PosedScan> key_frames = sample_key_frames(10);
  const MapInfo at_once = grow(make_map(), key_frames);

  MapStore other(open_database(directory_ / "other.db"));
  ASSERT_TRUE(other.put("another name", "text", "lidar", std::nullopt, "t8"));
  MapInfo in_parts = other.find("another name").value();
  for (const PosedScan& key_frame : key_frames) {
    in_parts =
        other.grow(in_parts.id, in_parts.revision, growth({}, std::span(&key_frame, 1)), "t9")
            .value();
  }
  EXPECT_EQ(in_parts.digest, at_once.digest);
  EXPECT_THAT(at_once.digest, ::testing::MatchesRegex("[0-9a-f]+"));
  EXPECT_THAT(at_once.digest, SizeIs(64));
}

TEST_F(MapStoreTest, HasTheDigestOfTheMovedContentAsIfItHadBeenMappedSo) {
  std::vector<PosedScan> key_frames = sample_key_frames(3);
  const MapInfo moved_away = [&] {
    const MapInfo map = grow(make_map("moved"), key_frames);
    const std::vector<Pose2> poses(3, Pose2{1.0, 2.0, 3.0});
    return store_.move_key_frames(map.id, map.revision, poses, outline_, "t5").value();
  }();
  for (PosedScan& key_frame : key_frames) key_frame.T_map_base_link = {1.0, 2.0, 3.0};
  EXPECT_EQ(grow(make_map("mapped"), key_frames).digest, moved_away.digest);
}

TEST_F(MapStoreTest, GivesBackContentBitForBit) {
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

TEST_F(MapStoreTest, GivesBackTheDescriptorsOfALargeMapWithoutStoringThem) {
  const MapInfo map = make_map();
  MapContent content = sample_content(2100);
  for (Feature& feature : content.features) feature.position.x() *= 0.1;
  content.descriptors = describe(content.features, content.descriptors.params);
  ASSERT_GT(content.descriptors.entries.size(), std::size_t{4} << 20U);
  ASSERT_TRUE(store_.store_content(map.id, map.revision, content));
  EXPECT_TRUE(is_same(store_.content(map.id).value()->content, content));
}

TEST_F(MapStoreTest, GivesBackContentWithoutFeatures) {
  const MapInfo map = make_map();
  ASSERT_TRUE(store_.store_content(map.id, map.revision, MapContent{}));
  EXPECT_TRUE(is_same(store_.content(map.id).value()->content, MapContent{}));
}

TEST_F(MapStoreTest, HasNoContentAtFirst) { EXPECT_FALSE(store_.content(make_map().id).value()); }

TEST_F(MapStoreTest, KeepsOlderContentWithItsRevisionWhenTheMapGrows) {
  const MapInfo map = grow(make_map(), 2);
  ASSERT_TRUE(store_.store_content(map.id, map.revision, sample_content(3)));
  grow(map, 1);
  EXPECT_EQ(store_.content(map.id).value()->revision, map.revision);
}

TEST_F(MapStoreTest, IgnoresContentOfARevisionThatHasPassed) {
  const MapInfo map = grow(make_map(), 2);
  const MapInfo newer = grow(map, 1);
  ASSERT_TRUE(store_.store_content(newer.id, newer.revision, sample_content(5)));
  ASSERT_TRUE(store_.store_content(map.id, map.revision, sample_content(3)));
  EXPECT_EQ(store_.content(map.id).value()->revision, newer.revision);
  EXPECT_EQ(store_.find("office")->feature_count, 5U);
}

TEST_F(MapStoreTest, RefusesAKeyFrameWithAFlippedBit) {
  const MapInfo map = grow(make_map(), 2);
  Blob blob = encode_key_frame(sample_key_frame(0));
  blob[50] ^= 1;
  SQLite::Statement damage(database_->connection(),
                           "UPDATE key_frames SET scan = ? WHERE ordinal = 1");
  damage.bind(1, blob.data(), static_cast<int>(blob.size()));
  damage.exec();
  EXPECT_EQ(store_.key_frames(map.id).error().code, ErrorCode::kCorruptData);
}

TEST_F(MapStoreTest, RefusesAMapThatLostAKeyFrame) {
  const MapInfo map = grow(make_map(), 3);
  database_->connection().exec("DELETE FROM key_frames WHERE ordinal = 1");
  EXPECT_EQ(store_.key_frames(map.id).error().code, ErrorCode::kCorruptData);
}

TEST_F(MapStoreTest, RefusesFeaturesAndDescriptorsThatDoNotBelongTogether) {
  const MapInfo map = make_map();
  ASSERT_TRUE(store_.store_content(map.id, map.revision, sample_content(3)));
  const Blob features = encode_features(sample_content(2).features);
  SQLite::Statement damage(database_->connection(), "UPDATE map_contents SET features = ?");
  damage.bind(1, features.data(), static_cast<int>(features.size()));
  damage.exec();
  EXPECT_EQ(store_.content(map.id).error().code, ErrorCode::kCorruptData);
}

TEST_F(MapStoreTest, ShowsAcknowledgedGrowthToASecondConnectionAtOnce) {
  MapStore other(open_database(directory_ / "maps.db"));
  const std::vector<PosedScan> key_frames = sample_key_frames(3);
  const MapInfo map = grow(make_map(), key_frames);
  EXPECT_TRUE(is_same(other.key_frames(map.id).value(), key_frames));
}

TEST_F(MapStoreTest, LosesNothingWhenTwoServersGrowOneMap) {
  const MapInfo map = make_map();
  constexpr int kGrowths = 40;
  const auto grow_often = [&](int server) {
    MapStore store(open_database(directory_ / "maps.db"));
    for (int done = 0; done < kGrowths;) {
      const std::uint64_t revision = store.find("office")->revision;
      const PosedScan key_frame = sample_key_frame(server * kGrowths + done);
      const auto grown =
          store.grow(map.id, revision,
                     growth(std::span(&key_frame.scan.stamp, 1), std::span(&key_frame, 1)), "t1");
      if (grown) {
        ++done;
      } else {
        ASSERT_EQ(grown.error().code, ErrorCode::kConflict) << grown.error().message;
      }
    }
  };
  {
    const std::jthread first(grow_often, 0);
    const std::jthread second(grow_often, 1);
  }
  const MapInfo grown = store_.find("office").value();
  EXPECT_EQ(grown.revision, map.revision + 2 * kGrowths);
  EXPECT_EQ(count("map_stamps"), 2 * kGrowths);
  const std::vector<PosedScan> key_frames = store_.key_frames(map.id).value();
  EXPECT_THAT(key_frames, SizeIs(2 * kGrowths));

  MapStore alone(open_database(directory_ / "alone.db"));
  ASSERT_TRUE(alone.put("office", std::nullopt, std::nullopt, std::nullopt, "t0"));
  const MapInfo empty = alone.find("office").value();
  EXPECT_EQ(alone.grow(empty.id, empty.revision, growth({}, key_frames), "t1")->digest,
            grown.digest);
}

OccupancyGrid small_plan(Cell first) {
  OccupancyGrid grid{
      .resolution = 0.1, .T_map_grid = {1, 2, 3}, .width = 2, .height = 1, .cells = {}};
  grid.cells = {first, Cell::kOccupied};
  return grid;
}

TEST_F(MapStoreTest, MakesAMapOfAFloorMapAndReplacesIt) {
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
  ASSERT_TRUE(store_.put_floor_map("plan", {.grid = other, .expected_revision = 1}, "t2"));
  const MapInfo second = store_.find("plan").value();
  EXPECT_EQ(second.revision, 2U);
  EXPECT_NE(second.digest, first.digest);
  EXPECT_EQ(store_.floor_map(second.id).value(), other);
}

TEST_F(MapStoreTest, TheSameFloorMapAgainChangesNothing) {
  const OccupancyGrid plan = small_plan(Cell::kFree);
  ASSERT_TRUE(store_.put_floor_map("plan", {.grid = plan}, "t1"));
  const std::string before = dump();
  EXPECT_EQ(
      store_.put_floor_map("plan", {.grid = plan, .expected_revision = 1}, "t2").value().revision,
      1U);
  EXPECT_EQ(dump(), before);
}

TEST_F(MapStoreTest, AFloorMapIsPutInTheMapThatItWasMadeForOnly) {
  const OccupancyGrid plan = small_plan(Cell::kFree);
  EXPECT_EQ(store_.put_floor_map("plan", {.grid = plan, .expected_revision = 1}, "t1").error().code,
            ErrorCode::kConflict);
  ASSERT_TRUE(store_.put_floor_map("plan", {.grid = plan}, "t1"));
  const std::string before = dump();
  EXPECT_EQ(store_.put_floor_map("plan", {.grid = plan}, "t2").error().code, ErrorCode::kConflict);
  EXPECT_EQ(dump(), before);
}

TEST_F(MapStoreTest, AFloorMapAndScansExcludeEachOther) {
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

TEST_F(MapStoreTest, AFloorMapGoesWithItsMap) {
  ASSERT_TRUE(store_.put_floor_map("plan", {.grid = small_plan(Cell::kFree)}, "t1"));
  ASSERT_TRUE(store_.remove("plan"));
  EXPECT_EQ(count("map_grids"), 0);
}

}  // namespace
}  // namespace cornerfix::storage

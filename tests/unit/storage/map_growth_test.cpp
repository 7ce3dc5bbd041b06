#include "unit/storage/map_store_fixture.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <thread>

namespace cornerfix::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

class MapGrowthTest : public MapStoreFixture {};

INSTANTIATE_TEST_SUITE_P(Engines, MapGrowthTest, ::testing::ValuesIn(engines()), EngineName());

TEST_P(MapGrowthTest, GivesBackKeyFramesBitForBit) {
  const MapInfo map = make_map();
  const std::vector<PosedScan> key_frames = sample_key_frames(25);
  grow(map, key_frames);
  EXPECT_TRUE(is_same(store_.key_frames(map.id).value(), key_frames));
}

TEST_P(MapGrowthTest, AppendsKeyFramesInOrder) {
  const MapInfo map = make_map();
  const std::vector<PosedScan> key_frames = sample_key_frames(10);
  MapInfo grown = grow(map, {key_frames.begin(), key_frames.begin() + 4});
  grow(grown, {key_frames.begin() + 4, key_frames.end()});
  EXPECT_TRUE(is_same(store_.key_frames(map.id).value(), key_frames));
}

TEST_P(MapGrowthTest, ReturnsTheEntryThatItStoredAfterGrowth) {
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

TEST_P(MapGrowthTest, KeepsTheRevisionWhenAGrowthBringsNoKeyFrame) {
  const MapInfo before = grow(make_map(), 3);
  const std::vector<double> stamps = {77.0};
  const MapInfo after = store_.grow(before.id, before.revision, growth(stamps, {}), "t2").value();
  EXPECT_EQ(after.revision, before.revision);
  EXPECT_EQ(after.digest, before.digest);
  EXPECT_THAT(store_.known_stamps(before.id, stamps).value(), ElementsAre(true));
}

TEST_P(MapGrowthTest, HasNoBoundsWithoutKeyFrames) {
  const MapInfo map = make_map();
  const std::vector<double> stamps = {1.0};
  EXPECT_FALSE(store_.grow(map.id, map.revision, growth(stamps, {}), "t1")->bounds);
  EXPECT_FALSE(store_.find("office")->bounds);
}

TEST_P(MapGrowthTest, KnowsTheStampsOfTheMapOnly) {
  const MapInfo office = make_map("office");
  const MapInfo lab = make_map("lab");
  const std::vector<double> stamps = {1.5, 0.0, 1e9 + 1e-6};
  ASSERT_TRUE(store_.grow(office.id, office.revision, growth(stamps, {}), "t1"));
  const std::vector<double> asked = {1e9 + 1e-6, 2.5, 1.5, -0.0};
  EXPECT_THAT(store_.known_stamps(office.id, asked).value(), ElementsAre(true, false, true, true));
  EXPECT_THAT(store_.known_stamps(lab.id, asked).value(), ElementsAre(false, false, false, false));
}

TEST_P(MapGrowthTest, RefusesGrowthFromAnotherRevision) {
  const MapInfo map = make_map();
  grow(map, 2);
  const std::string before = dump();
  const std::vector<PosedScan> key_frames = sample_key_frames(1);
  const auto late = store_.grow(map.id, map.revision, growth({}, key_frames), "t9");
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kConflict);
  EXPECT_EQ(dump(), before);
}

TEST_P(MapGrowthTest, RefusesGrowthOfADeletedMap) {
  const MapInfo map = make_map();
  ASSERT_TRUE(store_.remove("office"));
  EXPECT_EQ(store_.grow(map.id, map.revision, growth({}, {}), "t1").error().code,
            ErrorCode::kNotFound);
}

TEST_P(MapGrowthTest, LeavesNothingOfAGrowthThatFails) {
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

TEST_P(MapGrowthTest, MovesEveryKeyFrameAndNothingElseOfIt) {
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

TEST_P(MapGrowthTest, OutlinesAMovedMapAsToldAndLeavesAnEmptyOneWithoutBounds) {
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

TEST_P(MapGrowthTest, KeepsTheRevisionWhenNothingMoves) {
  const std::vector<PosedScan> key_frames = sample_key_frames(2);
  const MapInfo map = grow(make_map(), key_frames);
  const std::vector<Pose2> poses = {key_frames[0].T_map_base_link, key_frames[1].T_map_base_link};
  EXPECT_EQ(store_.move_key_frames(map.id, map.revision, poses, outline_, "t5")->revision,
            map.revision);
}

TEST_P(MapGrowthTest, RefusesATrajectoryOfAnotherLengthOrRevision) {
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

TEST_P(MapGrowthTest, HasTheSameDigestForTheSameContentInAnotherDatabase) {
  const std::vector<PosedScan> key_frames = sample_key_frames(10);
  const MapInfo at_once = grow(make_map(), key_frames);

  MapStore other(databases_.open("other"));
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

TEST_P(MapGrowthTest, HasTheDigestOfTheMovedContentAsIfItHadBeenMappedSo) {
  std::vector<PosedScan> key_frames = sample_key_frames(3);
  const MapInfo moved_away = [&] {
    const MapInfo map = grow(make_map("moved"), key_frames);
    const std::vector<Pose2> poses(3, Pose2{1.0, 2.0, 3.0});
    return store_.move_key_frames(map.id, map.revision, poses, outline_, "t5").value();
  }();
  for (PosedScan& key_frame : key_frames) key_frame.T_map_base_link = {1.0, 2.0, 3.0};
  EXPECT_EQ(grow(make_map("mapped"), key_frames).digest, moved_away.digest);
}

TEST_P(MapGrowthTest, RefusesAKeyFrameWithAFlippedBit) {
  const MapInfo map = grow(make_map(), 2);
  Blob blob = encode_key_frame(sample_key_frame(0));
  blob[50] ^= 1;
  databases_.run("maps",
                 "UPDATE key_frames SET scan = " + databases_.literal(blob) + " WHERE ordinal = 1");
  EXPECT_EQ(store_.key_frames(map.id).error().code, ErrorCode::kCorruptData);
}

TEST_P(MapGrowthTest, RefusesAMapThatLostAKeyFrame) {
  const MapInfo map = grow(make_map(), 3);
  databases_.run("maps", "DELETE FROM key_frames WHERE ordinal = 1");
  EXPECT_EQ(store_.key_frames(map.id).error().code, ErrorCode::kCorruptData);
}

TEST_P(MapGrowthTest, ShowsAcknowledgedGrowthToASecondConnectionAtOnce) {
  MapStore other(databases_.open("maps"));
  const std::vector<PosedScan> key_frames = sample_key_frames(3);
  const MapInfo map = grow(make_map(), key_frames);
  EXPECT_TRUE(is_same(other.key_frames(map.id).value(), key_frames));
}

TEST_P(MapGrowthTest, LosesNothingWhenTwoServersGrowOneMap) {
  const MapInfo map = make_map();
  constexpr int kGrowths = 40;
  const auto grow_often = [&](int server) {
    MapStore store(databases_.open("maps"));
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

  MapStore alone(databases_.open("alone"));
  ASSERT_TRUE(alone.put("office", std::nullopt, std::nullopt, std::nullopt, "t0"));
  const MapInfo empty = alone.find("office").value();
  EXPECT_EQ(alone.grow(empty.id, empty.revision, growth({}, key_frames), "t1")->digest,
            grown.digest);
}

}  // namespace
}  // namespace cornerfix::storage

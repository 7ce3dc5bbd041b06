#include "server/map_library.hpp"

#include <gmock/gmock.h>

#include <thread>

#include <cornerfix/map_image.hpp>

#include "unit/server/service_fixture.hpp"

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;

class MapLibraryTest : public ServiceTest {
 protected:
  std::vector<PosedScan> drive_ = testing::mapping_drive();
  Process process_{file()};
  MapLibrary& maps_ = *process_.maps;

  std::span<const PosedScan> part(std::size_t begin, std::size_t count) const {
    return std::span(drive_).subspan(begin, count);
  }
  static api::PutMapRequest parameters(const std::string& json) {
    api::PutMapRequest request;
    request.parameters_json = json;
    return request;
  }
  std::vector<api::StampedPose> trajectory(const Pose2& T) const {
    std::vector<api::StampedPose> poses;
    for (const PosedScan& scan : drive_) {
      poses.push_back({scan.scan.stamp, T * scan.T_map_base_link});
    }
    return poses;
  }
};

TEST_F(MapLibraryTest, KnowsNoMapThatWasNotPut) {
  EXPECT_EQ(maps_.grow("office", drive_).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(maps_.load("office").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(maps_.set_trajectory("office", trajectory({})).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(maps_.remove("office").error().code, ErrorCode::kNotFound);
}

TEST_F(MapLibraryTest, GrowsTheSameInOneBatchAndInMany) {
  ASSERT_TRUE(maps_.put("one", {}));
  ASSERT_TRUE(maps_.put("many", {}));
  ASSERT_TRUE(maps_.grow("one", drive_));
  for (std::size_t i = 0; i < drive_.size(); i += 5) {
    ASSERT_TRUE(maps_.grow("many", part(i, std::min<std::size_t>(5, drive_.size() - i))));
  }
  EXPECT_EQ(maps_.find("one")->digest, maps_.find("many")->digest);
  EXPECT_EQ(maps_.find("one")->feature_count, maps_.find("many")->feature_count);
}

TEST_F(MapLibraryTest, HasOneDigestHoweverABeamWithoutReturnWasTold) {
  ASSERT_TRUE(maps_.put("as null", {}));
  ASSERT_TRUE(maps_.put("as a number", {}));
  drive_[0].scan.ranges[7] = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(maps_.grow("as null", drive_));
  drive_[0].scan.ranges[7] = 1e3F;
  ASSERT_TRUE(maps_.grow("as a number", drive_));
  EXPECT_EQ(maps_.find("as null")->digest, maps_.find("as a number")->digest);
}

TEST_F(MapLibraryTest, IsUpdatedTheSameInOneBatchAndInManyAndByAnotherProcess) {
  const auto later = testing::mapping_drive(1e6, testing::refurnished_room());
  for (const char* name : {"one", "many"}) {
    ASSERT_TRUE(maps_.put(name, {}));
    ASSERT_TRUE(maps_.grow(name, drive_));
  }
  ASSERT_TRUE(maps_.grow("one", later));
  for (std::size_t i = 0; i < later.size(); i += 8) {
    Process restarted{file()};
    ASSERT_TRUE(restarted.maps->grow("many", std::span(later).subspan(i, 8)));
  }
  EXPECT_EQ(maps_.find("one")->digest, maps_.find("many")->digest);
  const auto one = maps_.load("one");
  const auto many = maps_.load("many");
  ASSERT_TRUE(one && many);
  EXPECT_EQ((*one)->grid(), (*many)->grid());
  EXPECT_EQ((*one)->features().size(), (*many)->features().size());
}

TEST_F(MapLibraryTest, AnUpdateGoesWithItsArchive) {
  ASSERT_TRUE(maps_.put("office", {}));
  ASSERT_TRUE(maps_.grow("office", drive_));
  ASSERT_TRUE(maps_.grow("office", testing::mapping_drive(1e6, testing::refurnished_room())));
  const auto archive = maps_.archive("office");
  ASSERT_TRUE(archive);
  ASSERT_TRUE(maps_.restore("copy", *archive));
  EXPECT_EQ(maps_.find("copy")->digest, maps_.find("office")->digest);
  EXPECT_EQ((*maps_.load("copy"))->grid(), (*maps_.load("office"))->grid());
}

TEST_F(MapLibraryTest, SaysWhatABatchDid) {
  ASSERT_TRUE(maps_.put("office", {}));
  const auto report = maps_.grow("office", drive_);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->accepted, drive_.size());
  EXPECT_EQ(report->duplicates, 0U);
  EXPECT_GT(report->key_frames, 10U);
  EXPECT_GT(report->features, 5U);
  EXPECT_EQ(report->revision, maps_.find("office")->revision);
}

TEST_F(MapLibraryTest, SkipsWhatItHoldsAlready) {
  make_map(process_, "office");
  const auto before = *maps_.find("office");
  const auto report = maps_.grow("office", drive_);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->accepted, 0U);
  EXPECT_EQ(report->duplicates, drive_.size());
  EXPECT_EQ(maps_.find("office")->digest, before.digest);
  EXPECT_EQ(report->revision, before.revision);
}

TEST_F(MapLibraryTest, SkipsAStampThatABatchHoldsTwice) {
  ASSERT_TRUE(maps_.put("office", {}));
  const std::vector<PosedScan> twice = {drive_[0], drive_[0], drive_[1]};
  const auto report = maps_.grow("office", twice);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->accepted, 2U);
  EXPECT_EQ(report->duplicates, 1U);
}

TEST_F(MapLibraryTest, GoesOnAfterARestart) {
  ASSERT_TRUE(maps_.put("whole", {}));
  ASSERT_TRUE(maps_.put("cut", {}));
  ASSERT_TRUE(maps_.grow("whole", drive_));
  ASSERT_TRUE(maps_.grow("cut", part(0, 20)));
  Process restarted(file());
  ASSERT_TRUE(restarted.maps->grow("cut", part(20, drive_.size() - 20)));
  EXPECT_EQ(restarted.maps->find("cut")->digest, maps_.find("whole")->digest);
}

TEST_F(MapLibraryTest, TakesTurnsWithAnotherProcess) {
  ASSERT_TRUE(maps_.put("alone", {}));
  ASSERT_TRUE(maps_.put("shared", {}));
  ASSERT_TRUE(maps_.grow("alone", drive_));
  Process other(file());
  for (std::size_t i = 0; i < drive_.size(); i += 4) {
    MapLibrary& turn = i % 8 == 0 ? maps_ : *other.maps;
    ASSERT_TRUE(turn.grow("shared", part(i, std::min<std::size_t>(4, drive_.size() - i))));
  }
  EXPECT_EQ(maps_.find("shared")->digest, maps_.find("alone")->digest);
}

TEST_F(MapLibraryTest, TakesBatchesOfThreadsOneAfterTheOther) {
  ASSERT_TRUE(maps_.put("office", {}));
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < drive_.size(); i += 12) {
    threads.emplace_back([&, i] { EXPECT_TRUE(maps_.grow("office", part(i, 12))); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(maps_.grow("office", drive_)->duplicates, drive_.size());
}

TEST_F(MapLibraryTest, ChangesAMapAtTheExpectedRevisionOnly) {
  make_map(process_, "office");
  const storage::KnownMap expected{maps_.find("office")->revision};
  Process other(file());
  ASSERT_TRUE(other.maps->put("office", {{}, {}, R"({"min_feature_count": 3})"}));
  const auto before = *maps_.find("office");
  PosedScan later = drive_.back();
  later.scan.stamp += 1.0;
  later.T_map_base_link.x += 1.0;
  for (const Error& error :
       {maps_.put("office", {"other", {}, {}}, expected).error(),
        maps_.grow("office", std::span(&later, 1), expected).error(),
        maps_.set_trajectory("office", trajectory({1.0, 0.0, 0.0}), expected).error(),
        maps_.remove("office", expected).error(),
        maps_.put("office", {}, storage::KnownMap{}).error(),
        maps_.put("nowhere", {}, expected).error()}) {
    EXPECT_EQ(error.code, ErrorCode::kConflict);
    EXPECT_EQ(error.field, "revision");
  }
  EXPECT_EQ(maps_.find("office")->digest, before.digest);
  EXPECT_EQ(maps_.find("office")->description, before.description);
  // What was made already is no conflict.
  EXPECT_EQ(maps_.grow("office", drive_, expected)->duplicates, drive_.size());
  EXPECT_TRUE(maps_.remove("office", storage::KnownMap{before.revision}));
}

TEST_F(MapLibraryTest, ReplacesOnlyTheDescriptionThatWasSeen) {
  make_map(process_, "office");
  const storage::MapInfo seen = *maps_.find("office");
  const storage::KnownMap known{seen.revision, seen.id, seen.description};
  Process other(file());
  ASSERT_TRUE(other.maps->put("office", {"first", {}, {}}, known));
  EXPECT_EQ(maps_.put("office", {"second", {}, {}}, known).error().field, "revision");
  EXPECT_EQ(maps_.put("office", {"second", {}, R"({"min_feature_count": 3})"}, known).error().field,
            "revision");
  EXPECT_EQ(maps_.find("office")->description, "first");
}

TEST_F(MapLibraryTest, KeepsLoadedMapsUntilTheyChange) {
  make_map(process_, "office");
  const auto first = *maps_.load("office");
  EXPECT_EQ(*maps_.load("office"), first);
  EXPECT_EQ(maps_.cache_use().maps, 1U);
  EXPECT_GT(maps_.cache_use().bytes, 1000U);
  ASSERT_TRUE(maps_.set_trajectory("office", trajectory({1.0, 0.0, 0.0})));
  const auto second = *maps_.load("office");
  EXPECT_GT(second->revision(), first->revision());
}

TEST_F(MapLibraryTest, LetsGoOfMapsBeyondItsLimit) {
  Process small(file(), {.max_map_bytes = 1, .max_mappers = 1});
  make_map(small, "one");
  make_map(small, "two");
  ASSERT_TRUE(small.maps->load("one"));
  ASSERT_TRUE(small.maps->load("two"));
  EXPECT_EQ(small.maps->cache_use().maps, 1U);
}

TEST_F(MapLibraryTest, StoresWhatItMadeForOthers) {
  make_map(process_, "office");
  const auto made = *maps_.load("office");
  Process other(file());
  const auto read = *other.maps->load("office");
  EXPECT_EQ(read->revision(), made->revision());
  EXPECT_EQ(read->grid(), made->grid());
  EXPECT_EQ(read->features().size(), made->features().size());
}

TEST_F(MapLibraryTest, MovesKeyFramesToATrajectory) {
  make_map(process_, "office");
  const auto before = *maps_.load("office");
  const double max_x_before = maps_.find("office")->bounds->max.x();
  const Pose2 T{3.0, -1.0, 0.0};
  const auto moved = maps_.set_trajectory("office", trajectory(T));
  ASSERT_TRUE(moved) << moved.error().message;
  EXPECT_GT(moved->revision, before->revision());
  EXPECT_NEAR(moved->bounds->max.x(), max_x_before + 3.0, 1e-9);
  const auto after = *maps_.load("office");
  ASSERT_EQ(after->features().size(), before->features().size());
  EXPECT_NEAR(after->features()[0].position.x(), before->features()[0].position.x() + 3.0, 1e-6);
}

TEST_F(MapLibraryTest, RefusesATrajectoryWithGaps) {
  make_map(process_, "office");
  const auto before = *maps_.find("office");
  auto poses = trajectory({1.0, 0.0, 0.0});
  poses.erase(poses.begin() + 10);
  poses[0].stamp += 0.002;  // Too far from the first keyframe.
  const auto refused = maps_.set_trajectory("office", poses);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().field, "/poses");
  EXPECT_THAT(refused.error().message, HasSubstr("at stamps 100, 102"));
  EXPECT_EQ(maps_.find("office")->digest, before.digest);
  EXPECT_EQ(maps_.find("office")->revision, before.revision);
}

TEST_F(MapLibraryTest, RefusesATrajectoryBeyondWhatAGridCanHold) {
  make_map(process_, "office");
  const auto before = *maps_.find("office");
  auto poses = trajectory({});
  for (auto pose = poses.end() - 20; pose != poses.end(); ++pose) {
    pose->T_map_base_link.x = pose->T_map_base_link.y = 20'000.0;
  }
  const auto refused = maps_.set_trajectory("office", poses);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().field, "/poses");
  EXPECT_THAT(refused.error().message, HasSubstr("more than its grid can hold"));
  EXPECT_EQ(maps_.find("office")->revision, before.revision);
  EXPECT_TRUE(maps_.load("office"));
}

TEST_F(MapLibraryTest, TellsTheFeaturesOfAMovedMapAtOnce) {
  make_map(process_, "office");
  auto poses = trajectory({});
  for (std::size_t i = 0; i < poses.size(); i += 2) poses[i].T_map_base_link.x += 0.5;
  const auto moved = maps_.set_trajectory("office", poses);
  ASSERT_TRUE(moved);
  const auto map = *maps_.load("office");
  EXPECT_EQ(moved->feature_count, map->features().size());
  EXPECT_EQ(maps_.find("office")->feature_count, map->features().size());
}

TEST_F(MapLibraryTest, TakesStampsWithinAMillisecond) {
  make_map(process_, "office");
  auto poses = trajectory({1.0, 0.0, 0.0});
  for (api::StampedPose& pose : poses) pose.stamp += 0.0009;
  std::ranges::reverse(poses);
  EXPECT_TRUE(maps_.set_trajectory("office", poses));
}

TEST_F(MapLibraryTest, RefusesTwoPosesOfOneStampThatDiffer) {
  make_map(process_, "office");
  auto poses = trajectory({1.0, 0.0, 0.0});
  poses.push_back(poses.front());
  EXPECT_TRUE(maps_.set_trajectory("office", poses));
  poses.back().T_map_base_link.x += 0.5;
  const auto refused = maps_.set_trajectory("office", poses);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "/poses");
  EXPECT_THAT(refused.error().message, HasSubstr("that differ, expected one"));
}

TEST_F(MapLibraryTest, MakesFeaturesAnewWhenParametersChange) {
  make_map(process_, "office");
  const auto before = *maps_.load("office");
  ASSERT_FALSE(*maps_.put("office", parameters(R"({"min_feature_count": 1})")));
  const auto after = *maps_.load("office");
  EXPECT_GT(after->revision(), before->revision());
  EXPECT_GE(after->features().size(), before->features().size());
}

TEST_F(MapLibraryTest, TellsTheFeaturesOfOtherParametersAtOnce) {
  make_map(process_, "office");
  ASSERT_TRUE(maps_.put("office", parameters(R"({"min_feature_count": 40})")));
  EXPECT_EQ(maps_.find("office")->feature_count, (*maps_.load("office"))->features().size());

  const OccupancyGrid grid = (*maps_.load("office"))->grid();
  ASSERT_TRUE(maps_.put_floor_map("plan", encode_grid_yaml(grid, "p.png"), encode_grid_png(grid)));
  ASSERT_TRUE(maps_.put("plan", parameters(R"({"features": {"suppression_radius_m": 3}})")));
  EXPECT_EQ(maps_.find("plan")->feature_count, (*maps_.load("plan"))->features().size());
}

TEST_F(MapLibraryTest, HoldsTheFeaturesOfItsParametersWhenFloorMapAndParametersArePutAtOnce) {
  make_map(process_, "office");
  const OccupancyGrid grid = (*maps_.load("office"))->grid();
  const std::string yaml = encode_grid_yaml(grid, "p.png");
  const std::vector<std::byte> image = encode_grid_png(grid);
  const auto wide = parameters(R"({"features": {"suppression_radius_m": 3}})");
  ASSERT_TRUE(maps_.put("expected", parameters(R"({"min_feature_count": 2})")));
  ASSERT_TRUE(maps_.put("expected", wide));
  ASSERT_TRUE(maps_.put_floor_map("expected", yaml, image));
  for (int round = 0; round < 8; ++round) {
    const std::string name = "plan" + std::to_string(round);
    ASSERT_TRUE(maps_.put(name, parameters(R"({"min_feature_count": 2})")));
    std::thread other([&] { EXPECT_TRUE(maps_.put_floor_map(name, yaml, image)); });
    EXPECT_TRUE(maps_.put(name, wide));
    other.join();
    EXPECT_EQ(maps_.find(name)->digest, maps_.find("expected")->digest);
    EXPECT_EQ(maps_.find(name)->feature_count, maps_.find("expected")->feature_count);
    EXPECT_EQ((*maps_.load(name))->features().size(), (*maps_.load("expected"))->features().size());
  }
}

TEST_F(MapLibraryTest, ReportsTheStagesOfAnImportAndStoresNothingWhenItIsGivenUp) {
  make_map(process_, "office");
  const OccupancyGrid grid = (*maps_.load("office"))->grid();
  const std::string yaml = encode_grid_yaml(grid, "p.png");
  const std::vector<std::byte> image = encode_grid_png(grid);
  std::vector<std::string> stages;
  double last = 0.0;
  ASSERT_TRUE(maps_.put_floor_map("plan", yaml, image, [&](std::string_view stage, double share) {
    EXPECT_GE(share, last);
    EXPECT_LE(share, 1.0);
    last = share;
    if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
    return true;
  }));
  EXPECT_THAT(stages,
              ::testing::ElementsAre("reading", "walls", "features", "descriptors", "storing"));
  for (const std::string& given_up : stages) {
    const auto left = maps_.put_floor_map(
        "other", yaml, image, [&](std::string_view stage, double) { return stage != given_up; });
    ASSERT_FALSE(left);
    EXPECT_EQ(left.error().code, ErrorCode::kUnavailable);
    EXPECT_EQ(maps_.find("other").error().code, ErrorCode::kNotFound);
  }
}

TEST_F(MapLibraryTest, RefusesALongYaml) {
  const auto refused = maps_.put_floor_map("plan", std::string(70'000, '#'), {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(refused.error().field, "/yaml");
}

TEST_F(MapLibraryTest, RefusesParametersWithWhichAGridCannotHoldTheMap) {
  ASSERT_TRUE(maps_.put("office", parameters(R"({"grid": {"resolution_m": 1}})")));
  drive_.back().T_map_base_link.x += 2000.0;
  drive_.back().T_map_base_link.y += 2000.0;
  ASSERT_TRUE(maps_.grow("office", drive_));
  const auto before = *maps_.find("office");
  api::PutMapRequest request = parameters(R"({"grid": {"resolution_m": 0.01}})");
  request.description = "finer";
  const auto refused = maps_.put("office", request);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().field, "/parameters/grid/resolution_m");
  EXPECT_EQ(maps_.find("office")->revision, before.revision);
  EXPECT_EQ(maps_.find("office")->description, before.description);
}

TEST_F(MapLibraryTest, RefusesPosesThatAreKilometresApart) {
  ASSERT_TRUE(maps_.put("office", {}));
  auto drive = testing::mapping_drive();
  drive.resize(2);
  drive[1].T_map_base_link.x += 4900.0;
  const auto refused = maps_.grow("office", drive);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().field, "/scans/1");
  EXPECT_THAT(refused.error().message, HasSubstr("are the poses right?"));
  EXPECT_EQ(maps_.find("office")->key_frame_count, 0U);
}

TEST_F(MapLibraryTest, KeepsParametersThatAreNotGiven) {
  ASSERT_TRUE(
      maps_.put("office", parameters(R"({"extractor": "vfp", "grid": {"max_range_m": 9}})")));
  ASSERT_TRUE(maps_.put("office", parameters(R"({"grid": {"resolution_m": 0.1}})")));
  const MapperParams params = api::mapper_params_from_json(maps_.find("office")->parameters_json);
  EXPECT_EQ(params.extractor, CornerExtractor::kVfp);
  EXPECT_EQ(params.grid.max_range_m, 9.0);
  EXPECT_EQ(params.grid.resolution_m, 0.1);
  const auto revision = maps_.find("office")->revision;
  ASSERT_TRUE(maps_.put("office", parameters(R"({"extractor": "vfp"})")));
  EXPECT_EQ(maps_.find("office")->revision, revision);
}

TEST_F(MapLibraryTest, ListsByPage) {
  for (const char* name : {"b", "a", "c"}) ASSERT_TRUE(maps_.put(name, {}));
  const auto page = *maps_.list("a", 1);
  ASSERT_EQ(page.size(), 1U);
  EXPECT_EQ(page[0].name, "b");
}

// --- drives without poses

}  // namespace
}  // namespace cornerfix::server

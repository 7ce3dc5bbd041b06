#include "server/map_library.hpp"

#include <SQLiteCpp/Database.h>
#include <gmock/gmock.h>

#include "unit/server/service_fixture.hpp"

namespace cornerfix::server {
namespace {

using storage::KnownMap;
using ::testing::HasSubstr;

class UnposedDriveTest : public ServiceTest {
 protected:
  std::vector<RobotScan> drive_ = testing::robot_drive(60).scans;
  Process process_{file()};
  MapLibrary& maps_ = *process_.maps;

  void SetUp() override { ASSERT_TRUE(maps_.put("office", {})); }
  std::span<const RobotScan> part(std::size_t begin, std::size_t count) const {
    return std::span(drive_).subspan(begin, count);
  }
};

TEST_F(UnposedDriveTest, BecomesAMapOfTheRoom) {
  const auto report = maps_.grow("office", drive_);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->accepted, drive_.size());
  EXPECT_GT(report->key_frames, 30U);
  EXPECT_TRUE(maps_.find("office")->drifts);
  const auto map = maps_.load("office");
  ASSERT_TRUE(map);
  EXPECT_GT((*map)->features().size(), 5U);
  // The room is 10 x 10 m, whichever way it lies in the frame of the run.
  std::size_t walls = 0;
  for (const Cell cell : (*map)->grid().cells) walls += cell == Cell::kOccupied ? 1 : 0;
  EXPECT_GT(walls, 300U);
  EXPECT_LT(walls, 3000U);
}

TEST_F(UnposedDriveTest, GoesOnInAnotherProcessAndLosesNothing) {
  ASSERT_TRUE(maps_.grow("office", part(0, 30)));
  const auto before = *maps_.find("office");
  Process restarted{file()};
  const auto again = restarted.maps->grow("office", part(20, 10));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->duplicates, 10U);
  EXPECT_EQ(again->revision, before.revision);
  const auto rest = restarted.maps->grow("office", part(30, 30));
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_GT(rest->key_frames, before.key_frame_count + 15);

  ASSERT_TRUE(maps_.put("whole", {}));
  ASSERT_TRUE(maps_.grow("whole", drive_));
  const auto whole = maps_.load("whole");
  const auto resumed = restarted.maps->load("office");
  ASSERT_TRUE(whole && resumed);
  EXPECT_NEAR((*resumed)->grid().width, (*whole)->grid().width, 4);
  EXPECT_NEAR((*resumed)->grid().height, (*whole)->grid().height, 4);
}

TEST_F(UnposedDriveTest, TellsHowFarTheTrajectoryIsOptimised) {
  ASSERT_TRUE(maps_.grow("office", drive_));
  double share = 0.0;
  ASSERT_TRUE(maps_.load("office", [&share](double done) {
    share = done;
    return true;
  }));
  EXPECT_EQ(share, 1.0);
}

TEST_F(UnposedDriveTest, BecomesTheSameMapAsAWholeRun) {
  ASSERT_TRUE(maps_.put("whole", {}));
  ASSERT_TRUE(maps_.grow("office", drive_));
  const auto expected = *maps_.load("office");
  std::vector<std::string> stages;
  const auto report = maps_.add_run("whole", drive_, [&](std::string_view stage, double share) {
    EXPECT_GE(share, 0.0);
    EXPECT_LE(share, 1.0);
    if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
    return true;
  });
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(stages, (std::vector<std::string>{"odometry", "trajectory", "storing"}));
  EXPECT_EQ(report->accepted, drive_.size());
  EXPECT_EQ(report->features, expected->features().size());
  EXPECT_EQ(maps_.find("whole")->digest, maps_.find("office")->digest);
  EXPECT_EQ(maps_.find("whole")->feature_count, expected->features().size());
  // What was stored is read, with nothing to be optimised.
  const auto stored = maps_.load("whole", [](double) { return false; });
  ASSERT_TRUE(stored);
  EXPECT_EQ((*stored)->grid(), expected->grid());
  const auto goes_on = [](std::string_view, double) { return true; };
  EXPECT_EQ(maps_.add_run("whole", drive_, goes_on, KnownMap{1})->duplicates, drive_.size());
}

TEST_F(UnposedDriveTest, ChangesNothingWhenAWholeRunIsGivenUp) {
  ASSERT_TRUE(maps_.grow("office", part(0, 20)));
  const auto before = *maps_.find("office");
  for (const std::string_view last : {"odometry", "trajectory", "storing"}) {
    const auto left = maps_.add_run(
        "office", part(20, 40), [last](std::string_view stage, double) { return stage != last; });
    ASSERT_FALSE(left) << last;
    EXPECT_EQ(left.error().code, ErrorCode::kUnavailable);
    EXPECT_EQ(maps_.find("office")->digest, before.digest);
    EXPECT_EQ(maps_.find("office")->revision, before.revision);
  }
  EXPECT_EQ(maps_.grow("office", part(20, 40))->accepted, 40U);
}

TEST_F(UnposedDriveTest, StoresAWholeRunWithItsContentOrNothing) {
  const auto goes_on = [](std::string_view, double) { return true; };
  const auto before = *maps_.find("office");
  SQLite::Database database(file().string(), SQLite::OPEN_READWRITE);
  for (const std::string table : {"map_contents", "map_sketches"}) {
    database.exec("CREATE TRIGGER fault BEFORE INSERT ON " + table +
                  " BEGIN SELECT RAISE(ABORT, 'fault'); END");
    EXPECT_FALSE(maps_.add_run("office", drive_, goes_on)) << table;
    database.exec("DROP TRIGGER fault");
    EXPECT_EQ(maps_.find("office")->revision, before.revision) << table;
    EXPECT_EQ(maps_.find("office")->key_frame_count, 0U) << table;
  }
  EXPECT_EQ(maps_.add_run("office", drive_, goes_on)->accepted, drive_.size());
}

TEST_F(UnposedDriveTest, TakesAWholeRunIntoTheExpectedRevisionOnly) {
  ASSERT_TRUE(maps_.grow("office", part(0, 20)));
  const auto changed = maps_.find("office")->revision;
  const auto goes_on = [](std::string_view, double) { return true; };
  const auto refused = maps_.add_run("office", part(20, 40), goes_on, KnownMap{changed - 1});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  EXPECT_EQ(maps_.find("office")->revision, changed);
  EXPECT_TRUE(maps_.add_run("office", part(20, 40), goes_on, KnownMap{changed}));
}

TEST_F(UnposedDriveTest, TakesAWholeRunIntoTheMapThatItWasGivenForOnly) {
  const storage::MapInfo seen = *maps_.find("office");
  ASSERT_TRUE(maps_.remove("office"));
  ASSERT_TRUE(maps_.put("office", {}));
  ASSERT_EQ(maps_.find("office")->revision, seen.revision);
  const auto goes_on = [](std::string_view, double) { return true; };
  const auto refused =
      maps_.add_run("office", part(0, 20), goes_on, KnownMap{seen.revision, seen.id});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  EXPECT_EQ(maps_.find("office")->key_frame_count, 0U);
}

TEST_F(UnposedDriveTest, TakesNoScansAtPoses) {
  ASSERT_TRUE(maps_.grow("office", drive_));
  const auto before = *maps_.find("office");
  const auto refused = maps_.grow("office", testing::mapping_drive());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  EXPECT_EQ(maps_.find("office")->digest, before.digest);
}

TEST_F(UnposedDriveTest, IsNotTakenByAMapOfScansAtPoses) {
  make_map(process_, "posed");
  const auto refused = maps_.grow("posed", drive_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  EXPECT_THAT(refused.error().message, HasSubstr("these have none"));
}

TEST_F(UnposedDriveTest, IsRefusedWhereItGoesBackInTime) {
  ASSERT_TRUE(maps_.grow("office", part(10, 20)));
  const auto before = *maps_.find("office");
  const auto refused = maps_.grow("office", part(0, 5));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().field, "/scans/0/stamp");
  EXPECT_EQ(maps_.find("office")->digest, before.digest);
  EXPECT_TRUE(maps_.grow("office", part(30, 5)));
}

TEST_F(UnposedDriveTest, GoesOnInACopyOfItsArchive) {
  ASSERT_TRUE(maps_.grow("office", part(0, 30)));
  const auto archive = maps_.archive("office");
  ASSERT_TRUE(archive);
  const auto copy = maps_.restore("copy", *archive);
  ASSERT_TRUE(copy) << copy.error().message;
  EXPECT_TRUE(copy->drifts);
  EXPECT_EQ(copy->digest, maps_.find("office")->digest);
  EXPECT_FALSE(maps_.grow("copy", testing::mapping_drive()));
  ASSERT_TRUE(maps_.grow("copy", part(30, 10)));
  ASSERT_TRUE(maps_.load("copy"));
  EXPECT_TRUE(maps_.find("copy")->drifts);
}

TEST_F(UnposedDriveTest, AndAFloorMapMakeNoMapTogether) {
  ASSERT_TRUE(maps_.grow("office", part(0, 10)));
  const OccupancyGrid grid = (*maps_.load("office"))->grid();
  const std::string yaml = encode_grid_yaml(grid, "office.png");
  const std::vector<std::byte> image = encode_grid_png(grid);
  const auto drawn_over = maps_.put_floor_map("office", yaml, image);
  ASSERT_FALSE(drawn_over);
  EXPECT_EQ(drawn_over.error().code, ErrorCode::kConflict);
  ASSERT_TRUE(maps_.put_floor_map("plan", yaml, image));
  const auto driven_over = maps_.grow("plan", part(0, 10));
  ASSERT_FALSE(driven_over);
  EXPECT_EQ(driven_over.error().code, ErrorCode::kConflict);
}

TEST_F(UnposedDriveTest, TakesATrajectoryThatWasOptimisedElsewhere) {
  ASSERT_TRUE(maps_.grow("office", drive_));
  const auto before = *maps_.find("office");
  std::vector<api::StampedPose> poses;
  const std::vector<Pose2> truth = testing::robot_drive(60).T_map_base_link;
  for (std::size_t i = 0; i < drive_.size(); ++i) poses.push_back({drive_[i].scan.stamp, truth[i]});
  const auto moved = maps_.set_trajectory("office", poses);
  ASSERT_TRUE(moved);
  EXPECT_FALSE(moved->drifts);
  EXPECT_NE(moved->digest, before.digest);
  EXPECT_TRUE(maps_.grow("office", testing::mapping_drive()));
}

}  // namespace
}  // namespace cornerfix::server

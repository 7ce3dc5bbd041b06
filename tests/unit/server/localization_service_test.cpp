#include "server/localization_service.hpp"

#include <gmock/gmock.h>

#include "unit/server/localization_service_fixture.hpp"

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;

TEST_F(LocalizationServiceTest, FindsTheRobot) {
  const std::string id = create(process_);
  std::string last;
  for (std::uint64_t i = 0; i < 10; ++i) last = answer(process_, id, batch(i));
  EXPECT_THAT(last, HasSubstr("localized in office"));
  EXPECT_EQ(service_.find(id)->status, Status::kLocalized);
  EXPECT_EQ(process_.events.scans, 30U);
  EXPECT_EQ(process_.events.fixes, 1U);
  EXPECT_EQ(process_.events.lost, 0U);
}

TEST_F(LocalizationServiceTest, FindsTheRobotInAnyMap) {
  ASSERT_TRUE(process_.maps->put("empty", {}));
  const std::string id = create(process_, {});
  std::string last;
  for (std::uint64_t i = 0; i < 10; ++i) last = answer(process_, id, batch(i));
  EXPECT_THAT(last, HasSubstr("localized in office"));
}

TEST_F(LocalizationServiceTest, TakesANewMapInWhenItSearchesAll) {
  const std::string id = create(process_, {});
  for (std::uint64_t i = 0; i < 5; ++i) answer(process_, id, batch(i));
  ASSERT_TRUE(process_.maps->put("another", {}));
  std::vector<PosedScan> drive = testing::mapping_drive(7000.0);
  for (PosedScan& scan : drive) scan.scan.ranges.assign(360, 2.0F);
  ASSERT_TRUE(process_.maps->grow("another", drive));
  std::string last;
  for (std::uint64_t i = 5; i < 10; ++i) last = answer(process_, id, batch(i));
  EXPECT_THAT(last, HasSubstr("localized in office"));
}

TEST_F(LocalizationServiceTest, LeavesOutAMapThatCannotBeLoadedWhenItSearchesAll) {
  make_map(process_, "broken");
  const auto broken = *process_.maps->find("broken");
  std::vector<Pose2> poses(broken.key_frame_count);
  poses.back() = {20'000.0, 20'000.0, 0.0};
  ASSERT_TRUE(process_.stores->with_maps([&](storage::MapStore& maps) {
    return maps.move_key_frames(broken.id, broken.revision, poses, {.bounds = broken.bounds}, kNow);
  }));
  ASSERT_EQ(process_.maps->load("broken").error().code, ErrorCode::kConflict);
  const std::string id = create(process_, {});
  std::string last;
  for (std::uint64_t i = 0; i < 10; ++i) last = answer(process_, id, batch(i));
  EXPECT_THAT(last, HasSubstr("localized in office"));

  const std::string named = create(process_, {"office", "broken"});
  EXPECT_EQ(service_.post_scans(named, batch(0)).error().code, ErrorCode::kConflict);
}

TEST_F(LocalizationServiceTest, KnowsNoMapOrSessionThatIsNotThere) {
  api::CreateSessionRequest request;
  request.robot = "cart-7";
  request.maps = {"office", "nowhere"};
  EXPECT_EQ(service_.create(request).error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(service_.list({})->sessions.empty());
  EXPECT_EQ(service_.find("none").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(service_.head("none").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(service_.reset("none").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(service_.remove("none").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(service_.post_scans("none", batch(0)).error().code, ErrorCode::kNotFound);
}

TEST_F(LocalizationServiceTest, StartsAnewAfterAReset) {
  const std::string id = create(process_);
  for (std::uint64_t i = 0; i < 5; ++i) answer(process_, id, batch(i));
  const auto view = service_.reset(id);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->expected_sequence, 5U);
  EXPECT_EQ(view->status, Status::kCollecting);
  auto early = batch(0);
  early.sequence = 5;
  answer(process_, id, early);  // Its stamps lie before those of the last batch.
}

TEST_F(LocalizationServiceTest, ARegionRestrictsTheSearchUntilAReset) {
  api::CreateSessionRequest request = session_of("cart-7");
  const StartRegion region{.map = "office", .center = {5.0, 5.0}, .radius_m = 8.0};
  request.region = region;
  const std::string id = service_.create(request).value().value().id;
  EXPECT_EQ(service_.find(id)->region, region);
  answer(process_, id, batch(0));
  EXPECT_EQ(service_.find(id)->region, region);
  EXPECT_EQ(Process(file()).localization.find(id)->region, region) << "after a restart";
  EXPECT_EQ(service_.list({}).value().sessions.front().region, region);
  const StartRegion other{.center = {1.0, 5.0}, .radius_m = 1.0};
  EXPECT_EQ(service_.reset(id, other)->region, other);
  EXPECT_FALSE(service_.reset(id)->region.has_value());
}

TEST_F(LocalizationServiceTest, RefusesARegionInAMapThatIsNotSearched) {
  make_map(process_, "hall");
  api::CreateSessionRequest request = session_of("cart-7");
  request.region = StartRegion{.map = "hall", .radius_m = 1.0};
  const auto refused = service_.create(request);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().field, "/near/map");
  request.maps.clear();
  EXPECT_TRUE(service_.create(request)) << "every map is searched";
  request.region->map = "nowhere";
  EXPECT_EQ(service_.create(request).error().code, ErrorCode::kNotFound);
  const std::string id = create(process_);
  EXPECT_EQ(service_.reset(id, request.region).error().code, ErrorCode::kInvalidArgument);
}

TEST_F(LocalizationServiceTest, RefusesABatchWhenItsMapWasDeleted) {
  const std::string id = create(process_);
  const std::string first = answer(process_, id, batch(0));
  ASSERT_TRUE(process_.maps->remove("office"));
  EXPECT_EQ(service_.post_scans(id, batch(1)).error().code, ErrorCode::kConflict);
  EXPECT_EQ(answer(process_, id, batch(0)), first);
  make_map(process_, "office");  // Another map of the same name.
  EXPECT_EQ(service_.post_scans(id, batch(1)).error().code, ErrorCode::kConflict);
}

TEST_F(LocalizationServiceTest,
       KnowsItsMapFromAnotherOfThatNameBeforeTheFirstBatchAndInAnotherProcess) {
  const std::string id = create(process_);
  ASSERT_TRUE(process_.maps->remove("office"));
  make_map(process_, "office");
  EXPECT_EQ(service_.post_scans(id, batch(0)).error().code, ErrorCode::kConflict);
  Process restarted(file());
  EXPECT_EQ(restarted.localization.post_scans(id, batch(0)).error().code, ErrorCode::kConflict);
}

TEST_F(LocalizationServiceTest, LeavesADeletedMapWhenItSearchesAll) {
  make_map(process_, "twin");
  ASSERT_TRUE(process_.maps->remove("twin"));
  make_map(process_, "spare");
  const std::string id = create(process_, {});
  answer(process_, id, batch(0));
  ASSERT_TRUE(process_.maps->remove("spare"));
  std::string last;
  for (std::uint64_t i = 1; i < 10; ++i) last = answer(process_, id, batch(i));
  EXPECT_THAT(last, HasSubstr("localized in office"));
}

TEST_F(LocalizationServiceTest, LocalizesInTheNewestRevision) {
  const std::string id = create(process_);
  for (std::uint64_t i = 0; i < 8; ++i) answer(process_, id, batch(i));
  std::vector<api::StampedPose> moved;
  for (const PosedScan& scan : testing::mapping_drive()) {
    moved.push_back({scan.scan.stamp, Pose2{0.02, 0.0, 0.0} * scan.T_map_base_link});
  }
  ASSERT_TRUE(process_.maps->set_trajectory("office", moved));
  EXPECT_THAT(answer(process_, id, batch(8)), HasSubstr("localized in office"));
}

TEST_F(LocalizationServiceTest, AnswersASingleQuestion) {
  const api::LocalizeRequest request{drive_.scans, {}};
  const auto answer = service_.localize("office", request);
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_THAT(*answer, HasSubstr("localized in office"));
  EXPECT_EQ(*service_.localize("office", request), *answer);
  EXPECT_EQ(service_.localize("nowhere", request).error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(service_.list({})->sessions.empty());
}

TEST_F(LocalizationServiceTest, AnswersAQuestionAboutAnEmptyMap) {
  ASSERT_TRUE(process_.maps->put("empty", {}));
  const auto answer = service_.localize("empty", {drive_.scans, {}});
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_THAT(*answer, HasSubstr("collecting"));
}

TEST_F(LocalizationServiceTest, ShowsTheLastScanAndTheSubmapsFeatures) {
  const std::string id = create(process_);
  EXPECT_FALSE(service_.find(id)->last_scan);
  answer(process_, id, batch(0));
  const auto view = *service_.find(id);
  ASSERT_TRUE(view.last_scan);
  EXPECT_EQ(view.last_scan->scan.stamp, drive_.scans[2].scan.stamp);
  EXPECT_FALSE(view.feature_points.empty());
}

TEST_F(LocalizationServiceTest, AfterAResetTheLastAnswerIsNoLongerShown) {
  const std::string id = create(process_);
  const std::string last = answer(process_, id, batch(0));
  ASSERT_TRUE(service_.reset(id));
  EXPECT_EQ(service_.find(id)->last_answer, "");
  EXPECT_EQ(Process(file()).localization.find(id)->last_answer, "");
  EXPECT_EQ(service_.list({}).value().sessions.front().last_answer, "");
  EXPECT_EQ(answer(process_, id, batch(0)), last) << "but comes again for a batch that was lost";
  const std::string next = answer(process_, id, batch(1));
  EXPECT_EQ(service_.find(id)->last_answer, next);
}

}  // namespace
}  // namespace cornerfix::server

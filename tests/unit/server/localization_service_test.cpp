#include "server/localization_service.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <thread>

#include "unit/server/service_fixture.hpp"

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;

class LocalizationServiceTest : public ServiceTest {
 protected:
  LocalizationServiceTest() { make_map(process_, "office"); }

  api::CreateSessionRequest session_of(const std::string& robot,
                                       std::vector<std::string> maps = {"office"}) const {
    const LaserScan& scan = drive_.scans[0].scan;
    api::CreateSessionRequest request;
    request.robot = robot;
    request.maps = std::move(maps);
    request.lidars.only = api::Lidar{.angle_min = scan.angle_min,
                                     .angle_increment = scan.angle_increment,
                                     .range_min = scan.range_min,
                                     .range_max = scan.range_max,
                                     .beams = {},
                                     .T_base_link_laser = {}};
    request.lidar_json = api::lidars_to_json(request.lidars);
    return request;
  }

  std::string create(Process& process, std::vector<std::string> maps = {"office"}) {
    const auto created = process.localization.create(session_of("cart-7", std::move(maps)));
    EXPECT_TRUE(created) << created.error().message;
    return created.value().value().id;
  }

  /// The batch of `count` scans that has `sequence`, when all batches have so many.
  api::SessionScansRequest batch(std::uint64_t sequence, std::size_t count = 3) const {
    const auto begin = drive_.scans.begin() + static_cast<std::ptrdiff_t>(sequence * count);
    return {sequence, {begin, begin + static_cast<std::ptrdiff_t>(count)}};
  }

  static std::string answer(Process& process, const std::string& id,
                            const api::SessionScansRequest& request) {
    const auto outcome = process.localization.post_scans(id, request);
    EXPECT_TRUE(outcome) << outcome.error().message;
    if (!outcome) return {};
    EXPECT_FALSE(outcome->expected_sequence.has_value());
    return outcome->answer;
  }

  testing::RobotDrive drive_ = testing::robot_drive();
  Process process_{file()};
  LocalizationService& service_ = process_.localization;
};

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

TEST_F(LocalizationServiceTest, AnswersTheSameBatchWithTheSameBytes) {
  const std::string id = create(process_);
  answer(process_, id, batch(0));
  const std::string first = answer(process_, id, batch(1));
  EXPECT_EQ(answer(process_, id, batch(1)), first);
  EXPECT_EQ(process_.events.scans, 6U);
}

TEST_F(LocalizationServiceTest, RefusesOtherScansWithTheLastSequence) {
  const std::string id = create(process_);
  const std::string first = answer(process_, id, batch(0));
  auto other = batch(1);
  other.sequence = 0;
  Process restarted(file());
  for (Process* process : {&process_, &restarted}) {
    const auto refused = process->localization.post_scans(id, other);
    ASSERT_TRUE(refused);
    EXPECT_TRUE(refused->is_another_batch);
    EXPECT_EQ(refused->expected_sequence, 1U);
    EXPECT_EQ(answer(*process, id, batch(0)), first);
  }
  ASSERT_TRUE(service_.reset(id));
  EXPECT_TRUE(service_.post_scans(id, other)->is_another_batch);
}

TEST_F(LocalizationServiceTest, SaysWhichSequenceItExpects) {
  const std::string id = create(process_);
  answer(process_, id, batch(0));
  answer(process_, id, batch(1));
  for (const std::uint64_t wrong : {0U, 3U, 100U}) {
    auto request = batch(0);
    request.sequence = wrong;
    EXPECT_EQ(service_.post_scans(id, request)->expected_sequence, 2U) << wrong;
  }
  EXPECT_EQ(service_.find(id)->expected_sequence, 2U);
}

TEST_F(LocalizationServiceTest, TakesNoHugeSequenceForTheOneBeforeTheFirst) {
  auto request = batch(0);
  request.sequence = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(service_.post_scans(create(process_), request)->expected_sequence, 0U);
}

TEST_F(LocalizationServiceTest, TellsStampsThatAreNearToEachOtherApart) {
  const std::string id = create(process_);
  auto request = batch(0);
  for (std::size_t i = 0; i < 3; ++i) request.scans[i].scan.stamp = 1e9 + static_cast<double>(i);
  answer(process_, id, request);
  request.sequence = 1;
  request.scans[0].scan.stamp = 1e9 + 2.0 - 1.2e-7;
  EXPECT_THAT(service_.post_scans(id, request).error().message,
              HasSubstr("1000000001.9999999 is not after 1000000002"));
}

TEST_F(LocalizationServiceTest, RefusesStampsThatDoNotIncreaseAndChangesNothing) {
  const std::string id = create(process_);
  const std::string first = answer(process_, id, batch(0));
  auto stale = batch(1);
  stale.scans[0].scan.stamp = drive_.scans[2].scan.stamp;
  const auto refused = service_.post_scans(id, stale);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().field, "/scans/0/stamp");
  EXPECT_EQ(service_.find(id)->expected_sequence, 1U);
  EXPECT_EQ(service_.find(id)->last_answer, first);
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

TEST_F(LocalizationServiceTest, GoesOnAfterARestartAsIfThereHadBeenNone) {
  const std::string with = create(process_);
  const std::string without = create(process_);
  std::string expected;
  for (std::uint64_t i = 0; i < 8; ++i) expected = answer(process_, without, batch(i));
  for (std::uint64_t i = 0; i < 6; ++i) answer(process_, with, batch(i));
  Process restarted(file());
  EXPECT_EQ(restarted.localization.find(with)->expected_sequence, 6U);
  answer(restarted, with, batch(6));
  const std::string last = answer(restarted, with, batch(7));
  EXPECT_EQ(last.substr(with.size()), expected.substr(without.size()));
}

std::vector<Point2> points_base_link(const RobotScan& scan) {
  std::vector<Point2> points;
  for (const Point2& point : returns_as_points(scan.scan))
    points.push_back(scan.T_base_link_laser * point);
  return points;
}

TEST_F(LocalizationServiceTest, ShowsTheNewestScanOfTheLocalMapAfterARestart) {
  const std::string id = create(process_);
  for (std::uint64_t i = 0; i < 6; ++i) answer(process_, id, batch(i));
  const std::vector<Point2> last = points_base_link(*service_.find(id)->last_scan);
  Process restarted(file());
  const auto view = restarted.localization.find(id);
  ASSERT_TRUE(view->last_scan);
  const std::vector<Point2> shown = points_base_link(*view->last_scan);
  ASSERT_FALSE(shown.empty());
  const auto is_near_the_last = [&](const Point2& point) {
    return std::ranges::any_of(last, [&](const Point2& o) { return (o - point).norm() < 0.2; });
  };
  EXPECT_GT(10 * std::ranges::count_if(shown, is_near_the_last), 9 * std::ssize(shown));
}

TEST_F(LocalizationServiceTest, DoesNotBindLaterScansToTheNumberOfBeamsOfTheFirst) {
  const std::string id = create(process_);
  answer(process_, id, batch(0));
  const auto expected_beams = [&](const auto& head) {
    EXPECT_TRUE(head->lidars.only);
    return head->lidars.only ? head->lidars.only->beams : std::nullopt;
  };
  EXPECT_EQ(expected_beams(service_.head(id)), std::nullopt);
  EXPECT_EQ(expected_beams(Process(file()).localization.head(id)), std::nullopt);
}

TEST_F(LocalizationServiceTest, SharesASessionWithAnotherProcess) {
  const std::string shared = create(process_);
  const std::string alone = create(process_);
  Process other(file());
  std::string expected;
  std::string last;
  for (std::uint64_t i = 0; i < 8; ++i) {
    expected = answer(process_, alone, batch(i));
    last = answer(i % 2 == 0 ? process_ : other, shared, batch(i));
  }
  EXPECT_EQ(last.substr(shared.size()), expected.substr(alone.size()));
  EXPECT_EQ(answer(process_, shared, batch(7)), last);
  EXPECT_EQ(answer(other, shared, batch(7)), last);
}

TEST_F(LocalizationServiceTest, SeesAResetByAnotherProcess) {
  const std::string id = create(process_);
  for (std::uint64_t i = 0; i < 5; ++i) answer(process_, id, batch(i));
  Process other(file());
  ASSERT_TRUE(other.localization.reset(id));
  auto early = batch(0);
  early.sequence = 5;
  answer(process_, id, early);
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

TEST_F(LocalizationServiceTest, AnswersRobotsSideBySide) {
  std::vector<std::string> ids;
  for (int i = 0; i < 8; ++i) ids.push_back(create(process_));
  std::vector<std::string> last(ids.size());
  std::vector<std::thread> threads;
  for (std::size_t robot = 0; robot < ids.size(); ++robot) {
    threads.emplace_back([&, robot] {
      for (std::uint64_t i = 0; i < 8; ++i) last[robot] = answer(process_, ids[robot], batch(i));
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t robot = 0; robot < ids.size(); ++robot) {
    EXPECT_EQ(last[robot].substr(ids[robot].size()), last[0].substr(ids[0].size()));
  }
}

TEST_F(LocalizationServiceTest, TakesABatchPostedTwiceAtOnceOnlyOnce) {
  const std::string id = create(process_);
  std::vector<std::string> answers(4);
  std::vector<std::thread> threads;
  for (std::string& text : answers) {
    threads.emplace_back([&] { text = answer(process_, id, batch(0)); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(process_.events.scans, 3U);
  EXPECT_EQ(std::ranges::count(answers, answers[0]), 4);
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

TEST_F(LocalizationServiceTest, ListsAndForgetsSessions) {
  const std::string id = create(process_);
  create(process_);
  const std::string last = answer(process_, id, batch(0));
  const auto list = service_.list({}).value().sessions;
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].id, id);
  EXPECT_EQ(list[0].last_answer, last);
  ASSERT_TRUE(service_.remove(id));
  EXPECT_EQ(service_.list({}).value().sessions.size(), 1U);
  EXPECT_EQ(service_.post_scans(id, batch(1)).error().code, ErrorCode::kNotFound);
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

TEST_F(LocalizationServiceTest, CountsSessionsInMemory) {
  create(process_);
  EXPECT_EQ(service_.count_by_status(), (SessionCounts{1, 0, 0, 0}));
}

TEST_F(LocalizationServiceTest, KeepsTheLeastUsedSessionsInTheStoreOnly) {
  Process small(file(), {}, {.max_bytes = 1});
  std::vector<std::string> parked;
  std::vector<std::string> kept;
  for (int i = 0; i < 3; ++i) {
    parked.push_back(create(small));
    kept.push_back(create(process_));
  }
  const auto without_id = [](const std::string& answer) { return answer.substr(answer.find(' ')); };
  for (std::uint64_t i = 0; i < 5; ++i) {
    for (std::size_t robot = 0; robot < parked.size(); ++robot) {
      EXPECT_EQ(without_id(answer(small, parked[robot], batch(i))),
                without_id(answer(process_, kept[robot], batch(i))));
    }
  }
  const SessionCounts counts = small.localization.count_by_status();
  EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::size_t{0}), 1U);
}

TEST_F(LocalizationServiceTest, LimitsTheSessionsOfARobot) {
  Process strict(file(), {}, {.max_per_robot = 2});
  const std::string first = create(strict);
  create(strict);
  EXPECT_FALSE(strict.localization.create(session_of("cart-7")).value().has_value());
  EXPECT_TRUE(strict.localization.create(session_of("cart-8")).value().has_value());
  ASSERT_TRUE(strict.localization.remove(first));
  create(strict);
}

TEST_F(LocalizationServiceTest, RemovesSessionsThatWereNotUsedForLong) {
  const std::string id = create(process_);
  Process later(file(), {}, {.expired_before = [] { return std::string("2024-06-01T12:00:00Z"); }});
  EXPECT_EQ(later.localization.find(id).error().code, ErrorCode::kNotFound);
}

TEST_F(LocalizationServiceTest, ASessionThatIsSilentForLongIsStale) {
  const std::string id = create(process_);
  EXPECT_FALSE(service_.find(id)->is_stale);
  const auto at = [this](const std::string& stale_before) {
    return Process(file(), {}, {.stale_before = [=] { return stale_before; }});
  };
  Process soon = at("2024-05-01T12:00:00Z");
  EXPECT_FALSE(soon.localization.find(id)->is_stale);
  EXPECT_FALSE(soon.localization.list({}).value().sessions.front().is_stale);
  Process later = at("2024-05-01T12:00:01Z");
  EXPECT_TRUE(later.localization.find(id)->is_stale);
  EXPECT_TRUE(later.localization.list({}).value().sessions.front().is_stale);
}

TEST_F(LocalizationServiceTest, NamesTheNewestSessionOfTheRobotInTheOlderOnes) {
  const std::string first = create(process_);
  EXPECT_EQ(service_.find(first)->superseded_by, "");
  const std::string other = service_.create(session_of("cart-8")).value().value().id;
  const std::string second = create(process_);
  const std::string third = create(process_);
  EXPECT_EQ(service_.find(first)->superseded_by, third);
  EXPECT_EQ(service_.find(second)->superseded_by, third);
  EXPECT_EQ(service_.find(third)->superseded_by, "");
  EXPECT_EQ(service_.find(other)->superseded_by, "");
  const auto sessions = service_.list({}).value().sessions;
  ASSERT_EQ(sessions.size(), 4U);
  EXPECT_EQ(sessions[0].superseded_by, third);
  EXPECT_EQ(sessions[3].superseded_by, "");
  ASSERT_TRUE(service_.remove(third));
  EXPECT_EQ(service_.find(first)->superseded_by, second);
}

TEST_F(LocalizationServiceTest, AConflictHasTheStampOfTheLastScan) {
  const std::string id = create(process_);
  EXPECT_FALSE(service_.post_scans(id, batch(1))->last_stamp.has_value());
  answer(process_, id, batch(0));
  const double last = drive_.scans[2].scan.stamp;
  EXPECT_EQ(service_.post_scans(id, batch(5))->last_stamp, last);
  EXPECT_EQ(Process(file()).localization.post_scans(id, batch(5))->last_stamp, last);
  auto other = batch(1);
  other.sequence = 0;
  EXPECT_EQ(service_.post_scans(id, other)->last_stamp, last);
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

TEST_F(LocalizationServiceTest, ListsSessionsInPages) {
  std::vector<std::string> ids;
  for (int i = 0; i < 3; ++i) ids.push_back(create(process_));
  const SessionList first = service_.list({.limit = 2}).value();
  ASSERT_EQ(first.sessions.size(), 2U);
  EXPECT_EQ(first.sessions[1].id, ids[1]);
  const SessionList second = service_.list({.after = first.next.value(), .limit = 2}).value();
  ASSERT_EQ(second.sessions.size(), 1U);
  EXPECT_EQ(second.sessions[0].id, ids[2]);
  EXPECT_FALSE(second.next.has_value());
  EXPECT_TRUE(service_.list({.robot = "another"}).value().sessions.empty());
}

class SeveralMaps : public LocalizationServiceTest {
 protected:
  static constexpr std::size_t kBatches = 20;  // Enough new ground to confirm the pose.

  SeveralMaps() { drive_ = testing::robot_drive(3 * kBatches + 6); }

  void SetUp() override {
    ASSERT_TRUE(process_.maps->put("lab", {}));
    ASSERT_TRUE(process_.maps->grow("lab", drive_in_lab()));
  }

  /// In a room of the same form, but much larger.
  static std::vector<PosedScan> drive_in_lab(double first_stamp = 100.0) {
    constexpr float kScale = 1.7F;
    auto drive = testing::mapping_drive(first_stamp);
    for (PosedScan& scan : drive) {
      for (float& range : scan.scan.ranges) range *= kScale;
      scan.T_map_base_link.x *= kScale;
      scan.T_map_base_link.y *= kScale;
    }
    return drive;
  }

  /// A session in any map whose pose is confirmed: one room has too little new ground for that.
  std::string confirmed_session(Process& process) {
    const std::string id = create(process, {});
    for (std::size_t i = 0; i < kBatches; ++i) answer(process, id, batch(i));
    const auto stored = process.stores->with_sessions([&](storage::SessionStore& sessions) {
      storage::SessionRecord record = sessions.find(id).value().value();
      record.state.confirmed = true;
      return sessions.update(id, {.previous_sequence = record.expected_sequence,
                                  .expected_sequence = record.expected_sequence,
                                  .last_answer = record.last_answer,
                                  .state = &record.state});
    });
    EXPECT_TRUE(stored);
    return id;
  }
};

TEST_F(SeveralMaps, OnlyTheTrackedOneIsLoadedAfterARestart) {
  const std::string id = confirmed_session(process_);
  Process restarted(file());
  EXPECT_THAT(answer(restarted, id, batch(kBatches)), HasSubstr("in office"));
  EXPECT_EQ(restarted.maps->cache_use().loads, 1U);
}

TEST_F(SeveralMaps, OnlyTheOneThatChangedIsLoadedAgain) {
  Process process(file(), {.max_map_bytes = 1});
  const std::string id = create(process, {});
  answer(process, id, batch(0));
  EXPECT_EQ(process.maps->cache_use().loads, 2U);
  ASSERT_TRUE(process.maps->put("lab", {"another text", {}, {}}));
  answer(process, id, batch(1));
  EXPECT_EQ(process.maps->cache_use().loads, 2U);
  ASSERT_TRUE(process.maps->grow("lab", drive_in_lab(900.0)));
  answer(process, id, batch(2));
  EXPECT_EQ(process.maps->cache_use().loads, 3U);
}

TEST_F(SeveralMaps, AreNotSearchedTogetherWhenTheyAreTooLarge) {
  Process process(file(), {}, {.max_searched_map_bytes = 1});
  const std::string id = create(process, {});
  for (int i = 0; i < 2; ++i) {
    const auto refused = process.localization.post_scans(id, batch(0));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
    EXPECT_THAT(refused.error().message, HasSubstr("max_searched_map_bytes"));
  }
  EXPECT_EQ(process.maps->cache_use().loads, 1U);  // The second time it is known before.
  EXPECT_THAT(answer(process, create(process), batch(0)), HasSubstr(" 0 "));
}

}  // namespace
}  // namespace cornerfix::server

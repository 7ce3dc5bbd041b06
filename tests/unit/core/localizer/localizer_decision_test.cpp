#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "unit/core/localizer/localizer_runs.hpp"

namespace cornerfix {
namespace {

using namespace localizer_tests;

// --- A search over the budget

std::size_t count_searching(const std::vector<Answer>& answers) {
  return static_cast<std::size_t>(std::ranges::count(answers, Reason::kSearching, &Answer::reason));
}

Localizer localizer_with_budget(double ms) {
  LocalizerParams params;
  params.search_budget_ms = ms;
  return {{room_map(kRoomSeed)}, params};
}

TEST(LocalizerDecision, ASearchOverTheBudgetContinuesAtTheNextScans) {
  const std::vector<Moment> moments = room_drive(kRoomSeed, 60);
  Localizer bounded = localizer_with_budget(0.3);
  Localizer unbounded = localizer_with_budget(1e6);
  const std::vector<Answer> in_parts = answers_of(bounded, moments);
  const std::vector<Answer> at_once = answers_of(unbounded, moments);
  EXPECT_GT(count_searching(in_parts), 0U);
  EXPECT_EQ(count_searching(at_once), 0U);
  EXPECT_EQ(count_wrong(in_parts, moments), 0U);
  EXPECT_EQ(in_parts.back().status, Status::kLocalized);
  EXPECT_EQ(at_once.back().status, Status::kLocalized);
}

TEST(LocalizerDecision, ASearchEndsWhileTheRobotStands) {
  Localizer localizer = localizer_with_budget(0.05);
  Moment moment = room_drive(kRoomSeed, 1).front();
  Answer answer = localizer.process(moment.scan);
  ASSERT_EQ(answer.reason, Reason::kSearching);
  constexpr int kMostScans = 1000;
  int scans = 0;
  for (; scans < kMostScans && answer.reason == Reason::kSearching; ++scans) {
    moment.scan.scan.stamp += 0.1;
    answer = localizer.process(moment.scan);
  }
  EXPECT_LT(scans, kMostScans);
  EXPECT_TRUE(answer.searched);
}

TEST(LocalizerDecision, NewMapsBeginASuspendedSearchAnew) {
  Localizer localizer = localizer_with_budget(0.05);
  const std::vector<Moment> moments = room_drive(kRoomSeed, 2);
  ASSERT_EQ(localizer.process(moments[0].scan).reason, Reason::kSearching);
  localizer.replace_maps({testing::make_map(testing::random_room(kRoomSeed), {0.0, 0.0})});
  EXPECT_EQ(localizer.process(moments[1].scan).reason, Reason::kSearching);
}

// --- Knowing that it does not know

TEST(LocalizerDecision, ASymmetricRoomIsAmbiguous) {
  const SceneBuilder room = SceneBuilder().room({-4, -2.5}, {4, 2.5});
  const LocalizationMapPtr map = testing::make_map(room, {0.0, 0.0});
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Method method = method_for(seed);
    const Pose2 start{0.4 * static_cast<double>(seed) - 1.5, 0.3, static_cast<double>(seed)};
    const std::vector<Moment> moments = drive(room, {}, testing::wander(room, start, 15), seed);
    const std::vector<Answer> answers = answers_of({map}, with(method), moments);
    SCOPED_TRACE(std::string(to_string(method)) + ", seed " + std::to_string(seed));
    EXPECT_EQ(count(answers, Status::kLocalized), 0U);
    if (method != Method::kIndexed) continue;  // four corners are too few for the paper's votes
    EXPECT_EQ(answers.back().status, Status::kAmbiguous) << to_string(answers.back().reason);
  }
}

TEST(LocalizerDecision, AnAmbiguousAnswerNamesBothPlaces) {
  const SceneBuilder room = SceneBuilder().room({-4, -2.5}, {4, 2.5});
  const std::vector<Moment> moments =
      drive(room, {}, testing::wander(room, {1.0, 0.3, 1.0}, 15), 1);
  const Answer answer =
      answers_of({testing::make_map(room, {0.0, 0.0})}, with(Method::kIndexed), moments).back();
  ASSERT_EQ(answer.status, Status::kAmbiguous);
  const Pose2 truth = moments.back().T_map_base_link;
  const Pose2 twin{-truth.x, -truth.y, wrap_angle(truth.yaw + kPi)};
  std::vector<Pose2> named;
  for (const RankedHypothesis& hypothesis : answer.hypotheses) {
    named.push_back(hypothesis.T_map_base_link);
  }
  EXPECT_THAT(named, ::testing::Contains(IsPoseNear(truth, kRightMetres, kRightRadians)));
  EXPECT_THAT(named, ::testing::Contains(IsPoseNear(twin, kRightMetres, kRightRadians)));
}

TEST(LocalizerDecision, AForeignRoomIsCollecting) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const std::vector<Answer> answers =
        answers_of({room_map(seed)}, with(method_for(seed)), room_drive(seed + 20, 15));
    SCOPED_TRACE("seed " + std::to_string(seed));
    EXPECT_EQ(count(answers, Status::kLocalized), 0U);
    EXPECT_EQ(answers.back().status, Status::kCollecting);
    EXPECT_NE(answers.back().reason, Reason::kNone);
  }
}

/// Two rooms that are the same, far apart.
LocalizationMapPtr twin_rooms(std::uint64_t seed) {
  const Pose2 T{30.0, 3.0, kPi / 2.0};
  std::vector<PosedScan> scans = testing::mapping_scans(testing::random_room(seed), {0.0, 0.0});
  const std::vector<PosedScan> one = scans;
  for (PosedScan scan : one) {
    scan.T_map_base_link = T * scan.T_map_base_link;
    scans.push_back(std::move(scan));
  }
  return std::make_shared<const LocalizationMap>("twins", 1, testing::map_content(scans));
}

TEST(LocalizerDecision, OneOfTwoIdenticalRoomsIsNeverTakenForTheOther) {
  const auto map = twin_rooms(7);
  for (const Method method : kMethods) {
    const std::vector<Moment> moments = room_drive(7, 12);
    const std::vector<Answer> answers = answers_of({map}, with(method), moments);
    SCOPED_TRACE(to_string(method));
    EXPECT_EQ(count(answers, Status::kLocalized), 0U);
    EXPECT_GT(count(answers, Status::kAmbiguous), 0U);
  }
}

TEST(LocalizerDecision, IdenticalRoomsOfOneOfManyMapsAreToldApartNoBetter) {
  for (std::uint64_t seed = 5; seed <= 8; ++seed) {
    std::vector<LocalizationMapPtr> maps{twin_rooms(seed)};
    while (maps.size() < 6) maps.push_back(room_map(seed + 10 * maps.size()));
    for (const bool first : {true, false}) {
      const std::vector<Answer> answers =
          answers_of(maps, with(Method::kIndexed), room_drive(seed, 12));
      EXPECT_EQ(count(answers, Status::kLocalized), 0U)
          << "seed " << seed << (first ? ", first" : ", last");
      std::ranges::reverse(maps);
    }
  }
}

TEST(LocalizerDecision, AMirroredMapIsAForeignOne) {
  for (std::uint64_t seed = 8; seed <= 13; ++seed) {
    const LocalizationMapPtr map =
        testing::make_map(mirrored(testing::random_room(seed)), {0.0, 0.0});
    const std::vector<Answer> answers =
        answers_of({map}, with(method_for(seed)), room_drive(seed, 12));
    EXPECT_EQ(count(answers, Status::kLocalized), 0U) << "seed " << seed;
  }
}

}  // namespace
}  // namespace cornerfix

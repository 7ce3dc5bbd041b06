#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "unit/core/localizer/localizer_runs.hpp"

namespace cornerfix {
namespace {

using namespace localizer_tests;

// --- Many maps

/// `own`, its mirror image, and rooms of other robots.
std::vector<LocalizationMapPtr> maps_with(const LocalizationMapPtr& own, std::uint64_t seed,
                                          std::size_t count) {
  std::vector<LocalizationMapPtr> maps{
      testing::make_map(mirrored(testing::random_room(seed)), {0.0, 0.0}, "mirrored")};
  while (maps.size() + 1 < count) maps.push_back(room_map(seed + 10 * maps.size()));
  maps.push_back(own);
  return maps;
}

void expect_the_right_one_of(std::size_t count, std::uint64_t seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  const LocalizationMapPtr own = room_map(seed);
  const std::vector<Moment> moments = room_drive(seed, 15);
  const std::vector<Answer> answers =
      answers_of(maps_with(own, seed, count), with(Method::kIndexed), moments);
  for (const Answer& answer : answers) {
    if (!answer.pose) continue;
    EXPECT_EQ(answer.pose->map, own);
  }
  expect_localized_at(answers.back(), moments.back().T_map_base_link);
}

TEST(Localizer, FindsTheRightOneOfAFewMaps) {
  for (std::uint64_t seed = 8; seed <= 9; ++seed) expect_the_right_one_of(4, seed);
}

TEST(Localizer, FindsTheRightOneOfManyMaps) {
  for (std::uint64_t seed = 8; seed <= 12; ++seed) expect_the_right_one_of(9, seed);
}

TEST(Localizer, TheSamePlaceInTwoMapsIsAmbiguous) {
  const LocalizationMapPtr one = room_map(9);
  const LocalizationMapPtr other = room_map(9);
  const std::vector<Answer> answers =
      answers_of({one, other}, with(Method::kIndexed), room_drive(9, 15));
  EXPECT_EQ(count(answers, Status::kLocalized), 0U);
  EXPECT_EQ(answers.back().status, Status::kAmbiguous);
}

TEST(Localizer, TwinsAmongManyMapsGetNoFixInWhateverOrderTheyAreSearched) {
  for (std::uint64_t seed = 41; seed < 44; ++seed) {
    const SceneBuilder room = testing::random_room(seed);
    std::vector<LocalizationMapPtr> maps{
        room_map(seed + 10), testing::make_map(room, {0.0, 0.0}, "one"), room_map(seed + 20),
        room_map(seed + 30), testing::make_map(room, {0.0, 0.0}, "other")};
    for (std::size_t turn = 0; turn < maps.size(); ++turn) {
      std::rotate(maps.begin(), maps.begin() + 1, maps.end());
      const std::vector<Answer> answers =
          answers_of(maps, with(Method::kIndexed), room_drive(seed, 12));
      EXPECT_EQ(count(answers, Status::kLocalized), 0U) << "seed " << seed << ", turn " << turn;
    }
  }
}

TEST(Localizer, AGapThatIsTooSmallIsNoContradiction) {
  LocalizerParams params = with(Method::kIndexed);
  params.acceptance.min_gap = 1e6;
  const std::vector<Answer> answers = answers_of({room_map(9)}, params, room_drive(9, 12));
  EXPECT_EQ(count(answers, Status::kLocalized), 0U);
  EXPECT_EQ(answers.back().reason, Reason::kFewEvidence);
}

TEST(Localizer, WithoutMapsIsCollecting) {
  for (const Method method : kMethods) {
    const std::vector<Answer> answers = answers_of({}, with(method), room_drive(1, 8));
    EXPECT_EQ(count(answers, Status::kCollecting), answers.size());
    EXPECT_EQ(answers.back().reason, Reason::kNoMatch);
  }
}

TEST(Localizer, AnEmptyMapIsNoPlace) {
  const auto empty = std::make_shared<const LocalizationMap>("empty", 1, testing::map_content({}));
  for (const Method method : kMethods) {
    const std::vector<Answer> answers = answers_of({empty}, with(method), room_drive(1, 8));
    EXPECT_EQ(count(answers, Status::kCollecting), answers.size());
    EXPECT_NE(answers.back().reason, Reason::kNone);
  }
}

TEST(Localizer, ANewRevisionOfTheMapIsTakenUpWhileLocalized) {
  const LocalizationMapPtr old = room_map(10);
  const LocalizationMapPtr fresh =
      testing::make_map(testing::random_room(10), {0.0, 0.0}, "map", 2);
  const std::vector<Moment> moments = room_drive(10, 20);
  Localizer localizer({old}, with(Method::kIndexed));
  const std::vector<Moment> before(moments.begin(), moments.begin() + 12);
  const std::vector<Moment> after(moments.begin() + 12, moments.end());
  ASSERT_EQ(answers_of(localizer, before).back().status, Status::kLocalized);
  localizer.replace_maps({fresh});
  EXPECT_EQ(localizer.maps().front(), fresh);
  for (const Answer& answer : answers_of(localizer, after)) {
    ASSERT_TRUE(answer.pose.has_value());
    EXPECT_EQ(answer.pose->map, fresh);
  }
}

TEST(Localizer, ARevisionThatNoLongerFitsIsNotTrusted) {
  const std::vector<Moment> moments = room_drive(10, 45);
  Localizer localizer({room_map(10)}, with(Method::kIndexed));
  const std::vector<Moment> before(moments.begin(), moments.begin() + 12);
  ASSERT_EQ(answers_of(localizer, before).back().status, Status::kLocalized);
  localizer.replace_maps({testing::make_map(testing::offices(), {1.0, 1.0})});
  const std::vector<Moment> after(moments.begin() + 12, moments.end());
  const std::vector<Answer> answers = answers_of(localizer, after);
  EXPECT_NE(answers.back().status, Status::kLocalized);
}

}  // namespace
}  // namespace cornerfix

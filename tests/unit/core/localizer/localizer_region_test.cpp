// Localizers that know where the robot may be at its first scan.
#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/floor_plans.hpp"
#include "support/map_maker.hpp"
#include "support/mapped_floor.hpp"
#include "support/matchers.hpp"
#include "support/simulated_drive.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;
using testing::Moment;

std::vector<Answer> answers_in(Localizer& localizer, const std::vector<Moment>& moments) {
  std::vector<Answer> answers;
  for (const Moment& moment : moments) answers.push_back(localizer.process(moment.scan));
  return answers;
}

std::size_t count_of(const std::vector<Answer>& answers, Status status) {
  return static_cast<std::size_t>(std::ranges::count(answers, status, &Answer::status));
}

/// In the left one of two rooms that are the same, 20 m apart.
class LocalizerInTwins : public ::testing::Test {
 protected:
  static std::vector<Moment> drive_left() {
    const Point2 points[] = {{2.0, 1.5}, {3.5, 2.5}, {3.0, 3.5}, {1.5, 2.5}};
    return testing::drive(testing::equal_rooms(), {}, testing::route(points, 0.25, 0.2), 4);
  }
  static LocalizerParams params() {
    LocalizerParams params;
    params.search_budget_ms = 1e6;  // Each search ends at its scan.
    return params;
  }

  const std::vector<Moment> moments_ = drive_left();
  Localizer localizer_{
      {testing::mapped_floor(testing::equal_rooms(), {{3.0, 2.5}, {23.0, 2.5}}, {27.0, 5.0})},
      params()};
};

TEST_F(LocalizerInTwins, AreAmbiguousWithoutARegion) {
  const std::vector<Answer> answers = answers_in(localizer_, moments_);
  EXPECT_EQ(count_of(answers, Status::kLocalized), 0U);
  EXPECT_FALSE(answers.back().is_given_region);
}

TEST_F(LocalizerInTwins, AreToldApartByTheRegion) {
  localizer_.reset(StartRegion{.center = {2.5, 2.0}, .radius_m = 1.5});
  const std::vector<Answer> answers = answers_in(localizer_, moments_);
  ASSERT_EQ(answers.back().status, Status::kLocalized);
  EXPECT_THAT(answers.back().pose->T_map_base_link,
              IsPoseNear(moments_.back().T_map_base_link, 0.15, 0.03));
  EXPECT_TRUE(answers.back().is_given_region);
  EXPECT_GT(answers.back().confidence, 0.99);
  for (const Answer& answer : answers) {
    for (const RankedHypothesis& one : answer.hypotheses)
      EXPECT_LT(one.T_map_base_link.x, 10.0) << "rivals are searched in the region only";
  }
}

TEST_F(LocalizerInTwins, TheRegionHoldsAtTheFirstScan) {
  const Pose2& start = moments_.front().T_map_base_link;
  localizer_.reset(StartRegion{
      .center = start.translation(), .radius_m = 0.4, .yaw = start.yaw, .yaw_tolerance_rad = 0.3});
  const std::vector<Answer> answers = answers_in(localizer_, moments_);
  ASSERT_EQ(answers.back().status, Status::kLocalized);
  EXPECT_THAT(answers.back().pose->T_map_base_link,
              IsPoseNear(moments_.back().T_map_base_link, 0.15, 0.03));
}

TEST_F(LocalizerInTwins, ARestoredOneKeepsItsRegion) {
  localizer_.reset(StartRegion{.center = {2.5, 2.0}, .radius_m = 1.5});
  for (const Moment& moment : moments_) {
    const Answer answer = localizer_.process(moment.scan);
    EXPECT_TRUE(answer.is_given_region);
    const LocalizerState state = localizer_.state();
    localizer_ = Localizer(localizer_.maps(), params());
    localizer_.restore(state);
  }
  EXPECT_EQ(localizer_.state().status, Status::kLocalized);
}

TEST_F(LocalizerInTwins, AResetEndsTheRegion) {
  localizer_.reset(StartRegion{.center = {2.5, 2.0}, .radius_m = 1.5});
  EXPECT_TRUE(localizer_.region().has_value());
  localizer_.reset();
  EXPECT_FALSE(localizer_.region().has_value());
  EXPECT_EQ(count_of(answers_in(localizer_, moments_), Status::kLocalized), 0U);
}

// --- A region that is wrong

class LocalizerWithWrongRegion : public ::testing::TestWithParam<StartRegion> {};

TEST_P(LocalizerWithWrongRegion, GivesNoPose) {
  const testing::SceneBuilder offices = testing::offices();
  Localizer localizer({testing::make_map(offices, {1.0, 1.0})}, {});
  localizer.reset(GetParam());
  const std::vector<Answer> answers = answers_in(
      localizer, testing::drive(offices, {}, testing::drive_through_offices(0.3, 0.2), 3));
  EXPECT_EQ(count_of(answers, Status::kLocalized), 0U);
  EXPECT_EQ(answers.back().status, Status::kCollecting);
  EXPECT_EQ(answers.back().reason, Reason::kPriorContradicted);
}

// The run begins at (1, 1), heading 0.2 rad.
INSTANTIATE_TEST_SUITE_P(
    Offices, LocalizerWithWrongRegion,
    ::testing::Values(
        StartRegion{.center = {13.5, 4.0}, .radius_m = 2.0},
        StartRegion{.center = {9.0, 4.0}, .radius_m = 2.0},
        StartRegion{.center = {5.0, 1.0}, .radius_m = 2.5},
        StartRegion{.center = {1.0, 1.0}, .radius_m = 2.0, .yaw = 3.0, .yaw_tolerance_rad = 1},
        StartRegion{.map = "elsewhere", .center = {1.0, 1.0}, .radius_m = 2.0},
        StartRegion{.center = {80.0, 1.0}, .radius_m = 2.0}));

// --- Afterwards

TEST(LocalizerWithRegion, ALostRobotIsSearchedEverywhere) {
  const testing::SceneBuilder offices = testing::offices();
  const Point2 in_the_left_room[] = {{2.0, 1.2}, {2.0, 4.5}, {3.5, 5.5}};
  const Point2 in_the_right_room[] = {
      {14.5, 3.0}, {14.0, 5.0}, {13.0, 3.5}, {13.0, 1.0}, {10.0, 1.0}};
  Localizer localizer({testing::make_map(offices, {1.0, 1.0})}, {});
  localizer.reset(StartRegion{.center = {2.0, 1.0}, .radius_m = 2.0});
  const std::vector<Answer> before = answers_in(
      localizer, testing::drive(offices, {}, testing::route(in_the_left_room, 0.3, 0.2), 1));
  ASSERT_EQ(before.back().status, Status::kLocalized);
  EXPECT_TRUE(before.back().is_given_region);
  const std::vector<Moment> after =
      testing::drive(offices, {}, testing::route(in_the_right_room, 0.3, 0.2), 2, 100.0);
  const std::vector<Answer> answers = answers_in(localizer, after);
  EXPECT_GT(count_of(answers, Status::kLost), 0U);
  ASSERT_EQ(answers.back().status, Status::kLocalized);
  EXPECT_FALSE(answers.back().is_given_region);
  EXPECT_THAT(answers.back().pose->T_map_base_link,
              IsPoseNear(after.back().T_map_base_link, 0.15, 0.03));
}

TEST(LocalizerWithRegion, FindsTheRobotInTheNamedOneOfManyMaps) {
  std::vector<LocalizationMapPtr> maps;
  const MapContent content =
      testing::map_content(testing::mapping_scans(testing::offices(), {1, 1}));
  for (const char* name : {"a", "b", "c", "d", "e", "f"})
    maps.push_back(std::make_shared<const LocalizationMap>(name, 1, content));
  Localizer localizer(maps, {});
  localizer.reset(StartRegion{.map = "d", .center = {2.0, 2.0}, .radius_m = 3.0});
  const std::vector<Moment> moments =
      testing::drive(testing::offices(), {}, testing::drive_through_offices(0.3, 0.2), 3);
  const std::vector<Answer> answers = answers_in(localizer, moments);
  ASSERT_EQ(answers.back().status, Status::kLocalized) << "six equal maps are no rivals";
  EXPECT_EQ(answers.back().pose->map->name(), "d");
}

}  // namespace
}  // namespace cornerfix

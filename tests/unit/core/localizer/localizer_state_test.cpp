#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "unit/core/localizer/localizer_runs.hpp"

namespace cornerfix {
namespace {

using namespace localizer_tests;

// --- State

class LocalizerRestored : public ::testing::TestWithParam<Method> {};

TEST_P(LocalizerRestored, AnswersAsIfItHadNotBeenInterrupted) {
  const SceneBuilder offices = testing::offices();
  const LocalizationMapPtr map = testing::make_map(offices, {1.0, 1.0});
  const std::vector<Moment> moments = drive(offices, {}, testing::drive_through_offices(), 3);
  Localizer whole({map}, with(GetParam()));
  Localizer stopped({map}, with(GetParam()));
  for (std::size_t i = 0; i < moments.size(); ++i) {
    SCOPED_TRACE("scan " + std::to_string(i));
    const Answer expected = whole.process(moments[i].scan);
    expect_alike(stopped.process(moments[i].scan), expected);
    if (i % 7 != 3) continue;
    const LocalizerState state = stopped.state();
    stopped = Localizer({map}, with(GetParam()));
    stopped.restore(state);
  }
}

INSTANTIATE_TEST_SUITE_P(Localizer, LocalizerRestored, ::testing::ValuesIn(kMethods),
                         [](const auto& test) { return std::string(to_string(test.param)); });

TEST(Localizer, StateOfARestoredOneIsTheState) {
  const std::vector<Moment> moments = room_drive(14, 10);
  Localizer localizer({room_map(14)}, with(Method::kIndexed));
  (void)answers_of(localizer, moments);
  const LocalizerState state = localizer.state();
  Localizer other(localizer.maps(), with(Method::kIndexed));
  other.restore(state);
  const LocalizerState again = other.state();
  EXPECT_EQ(again.submap.size(), state.submap.size());
  EXPECT_EQ(again.next_index, state.next_index);
  EXPECT_EQ(again.scans, state.scans);
  EXPECT_EQ(again.T_submap_base_link, state.T_submap_base_link);
  EXPECT_EQ(again.last_motion, state.last_motion);
  EXPECT_EQ(again.last_interval_s, state.last_interval_s);
  EXPECT_EQ(again.last_stamp, state.last_stamp);
  EXPECT_EQ(again.last_T_odom_base_link, state.last_T_odom_base_link);
  EXPECT_EQ(again.status, state.status);
  EXPECT_EQ(again.reason, state.reason);
  EXPECT_EQ(again.confidence, state.confidence);
  EXPECT_EQ(again.tracked_map, state.tracked_map);
  EXPECT_EQ(again.T_map_submap, state.T_map_submap);
  EXPECT_EQ(again.misfits, state.misfits);
  EXPECT_EQ(other.local_features_base_link().size(), localizer.local_features_base_link().size());
}

TEST(Localizer, AStateOfAMapThatIsGoneIsNotTrusted) {
  const std::vector<Moment> moments = room_drive(14, 12);
  Localizer localizer({room_map(14)}, with(Method::kIndexed));
  ASSERT_EQ(answers_of(localizer, moments).back().status, Status::kLocalized);
  Localizer other({}, with(Method::kIndexed));
  other.restore(localizer.state());
  RobotScan next = moments.back().scan;
  next.scan.stamp += 1.0;
  const Answer answer = other.process(next);
  EXPECT_EQ(answer.status, Status::kCollecting);
  EXPECT_FALSE(answer.pose.has_value());
}

TEST(Localizer, TheStateOfANewOneIsEmpty) {
  const LocalizerState state = Localizer({}, {}).state();
  EXPECT_TRUE(state.submap.empty());
  EXPECT_EQ(state.scans, 0U);
  EXPECT_EQ(state.tracked_map, -1);
  EXPECT_FALSE(state.last_stamp.has_value());
}

TEST(Localizer, SameScansSameAnswers) {
  for (const Method method : kMethods) {
    const std::vector<Moment> moments = room_drive(15, 15);
    const std::vector<Answer> one = answers_of({room_map(15)}, with(method), moments);
    const std::vector<Answer> two = answers_of({room_map(15)}, with(method), moments);
    for (std::size_t i = 0; i < one.size(); ++i) expect_same(one[i], two[i]);
  }
}

}  // namespace
}  // namespace cornerfix

#include <cornerfix/localizer.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/floor_plans.hpp"
#include "support/map_maker.hpp"
#include "support/simulated_drive.hpp"

namespace cornerfix {
namespace {

using testing::Moment;
using testing::SceneBuilder;

constexpr std::uint64_t kSeed = 14;

std::vector<Moment> room_run(std::size_t count) {
  const SceneBuilder room = testing::random_room(kSeed);
  return testing::drive(room, {}, testing::wander(room, {0.2, -0.3, 0.7}, count), kSeed);
}

std::vector<Answer> answers_of(Localizer& localizer, const std::vector<Moment>& moments) {
  std::vector<Answer> answers;
  for (const Moment& moment : moments) answers.push_back(localizer.process(moment.scan));
  return answers;
}

std::size_t count_searching(const std::vector<Answer>& answers) {
  return static_cast<std::size_t>(std::ranges::count(answers, Reason::kSearching, &Answer::reason));
}

std::size_t count_wrong(const std::vector<Answer>& answers, const std::vector<Moment>& moments,
                        double limit_m = 0.3) {
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i].pose &&
        distance(answers[i].pose->T_map_base_link, moments[i].T_map_base_link) > limit_m)
      ++wrong;
  }
  return wrong;
}

Localizer localizer_with_budget(double ms) {
  LocalizerParams params;
  params.search_budget_ms = ms;
  return {{testing::make_map(testing::random_room(kSeed), {0.0, 0.0})}, params};
}

TEST(LocalizerInterruptions, ASearchOverTheBudgetContinuesAtTheNextScans) {
  const std::vector<Moment> moments = room_run(60);
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

TEST(LocalizerInterruptions, ASearchEndsWhileTheRobotStands) {
  Localizer localizer = localizer_with_budget(0.05);
  Moment moment = room_run(1).front();
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

TEST(LocalizerInterruptions, NewMapsBeginASuspendedSearchAnew) {
  Localizer localizer = localizer_with_budget(0.05);
  const std::vector<Moment> moments = room_run(2);
  ASSERT_EQ(localizer.process(moments[0].scan).reason, Reason::kSearching);
  localizer.replace_maps({testing::make_map(testing::random_room(kSeed), {0.0, 0.0})});
  EXPECT_EQ(localizer.process(moments[1].scan).reason, Reason::kSearching);
}

/// Answers to `moments`, the last of them `pause_s` later than it was driven.
Answer answer_after_a_pause(std::vector<Moment> moments, double pause_s) {
  moments.back().scan.scan.stamp += pause_s;
  Localizer localizer = localizer_with_budget(1e6);
  const std::vector<Answer> answers = answers_of(localizer, moments);
  EXPECT_EQ(answers[answers.size() - 2].status, Status::kLocalized);
  return answers.back();
}

/// Whether the pose continues that of the first acceptance.
bool is_continuous(const Answer& answer) { return answer.pose && answer.pose->epoch == 1; }

TEST(LocalizerInterruptions, APauseWithoutOdometryEndsThePose) {
  std::vector<Moment> moments = room_run(60);
  for (Moment& moment : moments) moment.scan.T_odom_base_link.reset();
  EXPECT_TRUE(is_continuous(answer_after_a_pause(moments, 1.0)));
  EXPECT_FALSE(is_continuous(answer_after_a_pause(moments, 3.0)));
}

TEST(LocalizerInterruptions, APauseWithOdometryDoesNot) {
  EXPECT_TRUE(is_continuous(answer_after_a_pause(room_run(60), 3.0)));
}

/// A corridor of 40 m with recesses at irregular distances, and a lidar that does not see its ends.
SceneBuilder corridor() {
  SceneBuilder scene;
  scene.room({0.0, 0.0}, {40.0, 2.4});
  for (const double x : {2.0, 5.5, 7.2, 11.0, 16.4, 18.1, 22.9, 26.0, 30.5, 33.1, 37.4})
    scene.box({x, 0.15}, {0.6, 0.3}).box({x + 1.3, 2.3}, {0.9, 0.2});
  return scene;
}

std::vector<Moment> corridor_run() {
  const std::vector<Point2> points = {{1.0, 1.2}, {38.0, 1.2}};
  const testing::Robot robot{.lidar = {.beams = 360, .range_max_m = 8.0, .noise_m = 0.01}};
  return testing::drive(corridor(), robot, testing::route(points, 0.15), kSeed);
}

std::vector<Answer> corridor_answers(const std::vector<Moment>& moments) {
  Localizer localizer({testing::make_map(corridor(), {20.0, 1.2})}, LocalizerParams{});
  return answers_of(localizer, moments);
}

TEST(LocalizerInterruptions, OdometryThatHangsInACorridorDoesNotHoldThePose) {
  std::vector<Moment> moments = corridor_run();
  const std::size_t first = moments.size() / 3;
  for (std::size_t i = first; i < first + 50; ++i)
    moments[i].scan.T_odom_base_link = moments[first].scan.T_odom_base_link;
  const std::vector<Answer> answers = corridor_answers(moments);
  EXPECT_EQ(count_wrong(answers, moments), 0U);
  EXPECT_EQ(answers.back().status, Status::kLocalized);
}

TEST(LocalizerInterruptions, OdometryThatJumpsDoesNotMoveThePose) {
  std::vector<Moment> moments = corridor_run();
  for (std::size_t i = moments.size() / 2; i < moments.size(); ++i)
    *moments[i].scan.T_odom_base_link = Pose2{3.0, 1.0, 0.2} * *moments[i].scan.T_odom_base_link;
  const std::vector<Answer> answers = corridor_answers(moments);
  EXPECT_EQ(count_wrong(answers, moments), 0U);
  EXPECT_EQ(answers.back().status, Status::kLocalized);
}

/// Recesses at both ends, 40 m of bare walls between them.
SceneBuilder bare_corridor() {
  SceneBuilder scene;
  scene.room({0.0, 0.0}, {66.0, 2.4});
  for (const double x : {2.0, 5.5, 7.2, 11.0, 54.4, 56.1, 59.9, 63.0})
    scene.box({x, 0.15}, {0.6, 0.3}).box({x + 1.3, 2.3}, {0.9, 0.2});
  return scene;
}

TEST(LocalizerInterruptions, APoseThatABareCorridorDoesNotHoldIsNotGiven) {
  const std::vector<Point2> points = {{1.0, 1.2}, {64.0, 1.2}};
  const testing::Robot robot{.lidar = {.beams = 360, .range_max_m = 8.0, .noise_m = 0.01},
                             .has_odometry = false};
  const std::vector<Moment> moments =
      testing::drive(bare_corridor(), robot, testing::route(points, 0.15), kSeed);
  Localizer localizer({testing::make_map(bare_corridor(), {33.0, 1.2})}, LocalizerParams{});
  const std::vector<Answer> answers = answers_of(localizer, moments);
  EXPECT_EQ(count_wrong(answers, moments, 0.5), 0U);
  const auto is_uncertain = [](const Answer& answer) {
    return answer.status == Status::kLost && answer.reason == Reason::kFewEvidence;
  };
  const auto first = std::ranges::find_if(answers, is_uncertain);
  ASSERT_NE(first, answers.end());
  const Pose2& lost_at = moments[static_cast<std::size_t>(first - answers.begin())].T_map_base_link;
  EXPECT_GT(lost_at.x, 13.0);
  EXPECT_LT(lost_at.x, 53.0);
}

}  // namespace
}  // namespace cornerfix

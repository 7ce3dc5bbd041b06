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

TEST(LocalizerMotion, FindsARobotWithOdometryThatIsTenPerCentOff) {
  for (const double scale : {0.9, 1.1}) {
    const std::vector<Moment> moments = room_drive(4, 30, {.odometry_scale = scale});
    const std::vector<Answer> answers = answers_of({room_map(4)}, with(Method::kIndexed), moments);
    EXPECT_EQ(count_wrong(answers, moments), 0U);
    expect_localized_at(answers.back(), moments.back().T_map_base_link);
  }
}

TEST(LocalizerMotion, FindsARobotWhoseWheelsSlipped) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    std::vector<Moment> moments = room_drive(seed, 24);
    for (std::size_t i = 8; i < moments.size(); ++i) {
      Pose2& T_odom_base_link = *moments[i].scan.T_odom_base_link;
      T_odom_base_link = Pose2{0.5, 0.0, 0.0} * T_odom_base_link;
    }
    const auto answers = answers_of({room_map(seed)}, with(Method::kIndexed), moments);
    EXPECT_EQ(count_wrong(answers, moments), 0U) << "seed " << seed;
    expect_localized_at(answers.back(), moments.back().T_map_base_link);
  }
}

TEST(LocalizerMotion, FindsARobotWhoseScansAreLostOnTheWay) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 random(seed);
    std::vector<Moment> moments = room_drive(seed, 60);
    std::erase_if(moments, [&](const Moment&) { return random() % 3 != 0; });
    const auto answers = answers_of({room_map(seed)}, with(Method::kIndexed), moments);
    EXPECT_EQ(count_wrong(answers, moments), 0U) << "seed " << seed;
    expect_localized_at(answers.back(), moments.back().T_map_base_link);
  }
}

/// Answers to `moments`, the last of them `pause_s` later than it was driven.
Answer answer_after_a_pause(std::vector<Moment> moments, double pause_s) {
  moments.back().scan.scan.stamp += pause_s;
  LocalizerParams params;
  params.search_budget_ms = 1e6;  // Each search ends at its scan.
  Localizer localizer({room_map(kRoomSeed)}, params);
  const std::vector<Answer> answers = answers_of(localizer, moments);
  EXPECT_EQ(answers[answers.size() - 2].status, Status::kLocalized);
  return answers.back();
}

/// Whether the pose continues that of the first acceptance.
bool is_continuous(const Answer& answer) { return answer.pose && answer.pose->epoch == 1; }

TEST(LocalizerMotion, APauseWithoutOdometryEndsThePose) {
  std::vector<Moment> moments = room_drive(kRoomSeed, 60);
  for (Moment& moment : moments) moment.scan.T_odom_base_link.reset();
  std::vector<Moment> with_four_lost = moments;
  with_four_lost.erase(with_four_lost.end() - 5, with_four_lost.end() - 1);
  EXPECT_TRUE(is_continuous(answer_after_a_pause(with_four_lost, 0.0)));
  EXPECT_FALSE(is_continuous(answer_after_a_pause(moments, 3.0)));
}

TEST(LocalizerMotion, APauseWithOdometryDoesNot) {
  EXPECT_TRUE(is_continuous(answer_after_a_pause(room_drive(kRoomSeed, 60), 3.0)));
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
  const Robot robot{.lidar = {.beams = 360, .range_max_m = 8.0, .noise_m = 0.01}};
  return drive(corridor(), robot, testing::route(points, 0.15), kRoomSeed);
}

std::vector<Answer> corridor_answers(const std::vector<Moment>& moments) {
  Localizer localizer({testing::make_map(corridor(), {20.0, 1.2})}, LocalizerParams{});
  return answers_of(localizer, moments);
}

TEST(LocalizerMotion, OdometryThatHangsInACorridorDoesNotHoldThePose) {
  std::vector<Moment> moments = corridor_run();
  const std::size_t first = moments.size() / 3;
  for (std::size_t i = first; i < first + 50; ++i)
    moments[i].scan.T_odom_base_link = moments[first].scan.T_odom_base_link;
  const std::vector<Answer> answers = corridor_answers(moments);
  EXPECT_EQ(count_wrong(answers, moments), 0U);
  EXPECT_EQ(answers.back().status, Status::kLocalized);
}

TEST(LocalizerMotion, OdometryThatHangsFromStandstillOnDoesNotHoldThePose) {
  std::vector<Moment> moments = corridor_run();
  const std::size_t first = moments.size() / 3;
  const Moment standing = moments[first];
  moments.insert(moments.begin() + static_cast<std::ptrdiff_t>(first), 20, standing);
  double stamp = 0.0;
  for (Moment& moment : moments) moment.scan.scan.stamp = stamp += 0.2;
  for (std::size_t i = first; i < first + 70; ++i)
    moments[i].scan.T_odom_base_link = standing.scan.T_odom_base_link;
  const std::vector<Answer> answers = corridor_answers(moments);
  EXPECT_EQ(count_wrong(answers, moments), 0U);
  EXPECT_EQ(answers.back().status, Status::kLocalized);
}

TEST(LocalizerMotion, OdometryThatJumpsDoesNotMoveThePose) {
  std::vector<Moment> moments = corridor_run();
  for (std::size_t i = moments.size() / 2; i < moments.size(); ++i)
    *moments[i].scan.T_odom_base_link = Pose2{3.0, 1.0, 0.2} * *moments[i].scan.T_odom_base_link;
  const std::vector<Answer> answers = corridor_answers(moments);
  EXPECT_EQ(count_wrong(answers, moments), 0U);
  EXPECT_EQ(answers.back().status, Status::kLocalized);
}

}  // namespace
}  // namespace cornerfix

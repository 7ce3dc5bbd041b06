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

/// The robot drives in one room of the offices, then is carried to another.
struct Carried {
  std::vector<Moment> before;
  std::vector<Moment> after;
};

Carried carried_through_offices(bool has_odometry) {
  const SceneBuilder offices = testing::offices();
  const Robot robot{.has_odometry = has_odometry};
  const Point2 in_the_left_room[] = {{2.0, 1.2}, {2.0, 4.5}, {3.5, 5.5}};
  const Point2 in_the_right_room[] = {
      {14.5, 3.0}, {14.0, 5.0}, {13.0, 3.5}, {13.0, 1.0}, {10.0, 1.0}};
  Carried carried;
  carried.before = drive(offices, robot, testing::route(in_the_left_room, 0.3, 0.2), 1);
  carried.after = drive(offices, robot, testing::route(in_the_right_room, 0.3, 0.2), 2, 100.0);
  return carried;
}

TEST(LocalizerTracking, ARobotThatWasCarriedIsLostAndFoundAgain) {
  const LocalizationMapPtr map = testing::make_map(testing::offices(), {1.0, 1.0});
  for (const bool has_odometry : {true, false}) {
    SCOPED_TRACE(has_odometry ? "with odometry" : "without odometry");
    const Carried carried = carried_through_offices(has_odometry);
    Localizer localizer({map}, with(Method::kIndexed));
    ASSERT_EQ(answers_of(localizer, carried.before).back().status, Status::kLocalized);
    const std::vector<Answer> answers = answers_of(localizer, carried.after);
    ASSERT_GT(count(answers, Status::kLost), 0U);
    const auto lost = std::ranges::find(answers, Status::kLost, &Answer::status);
    EXPECT_EQ(std::count_if(answers.begin(), lost,
                            [](const Answer& answer) {
                              return answer.status == Status::kCollecting ||
                                     answer.status == Status::kAmbiguous;
                            }),
              0)
        << "from localized only lost follows";
    EXPECT_LE(lost - answers.begin(), 8) << "scans until it says so";
    EXPECT_LE(count_wrong(answers, carried.after), 8U);
    expect_localized_at(answers.back(), carried.after.back().T_map_base_link);
  }
}

TEST(LocalizerTracking, WhatIsLostStaysLostInAForeignRoom) {
  const std::vector<Moment> home = room_drive(12, 12);
  Localizer localizer({room_map(12)}, with(Method::kIndexed));
  ASSERT_EQ(answers_of(localizer, home).back().status, Status::kLocalized);
  std::vector<Moment> away = room_drive(32, 30);
  for (Moment& moment : away) moment.scan.scan.stamp += 100.0;
  const std::vector<Answer> answers = answers_of(localizer, away);
  EXPECT_EQ(answers.back().status, Status::kLost);
  EXPECT_NE(answers.back().reason, Reason::kNone);
}

TEST(LocalizerTracking, APoseIsWithdrawnWhenTheLidarIsCoveredOnTheWay) {
  const std::vector<Moment> moments = room_drive(1, 60);
  Localizer localizer({room_map(1)}, with(Method::kIndexed));
  std::size_t i = 0;
  while (i < 20) (void)localizer.process(moments[i++].scan);
  ASSERT_EQ(localizer.state().status, Status::kLocalized);
  Answer answer;
  for (; i < moments.size(); ++i) {
    RobotScan blind = moments[i].scan;
    std::ranges::fill(blind.scan.ranges, 0.0F);
    answer = localizer.process(blind);
  }
  EXPECT_EQ(answer.status, Status::kLost);
  EXPECT_EQ(answer.reason, Reason::kNoReturns);
  EXPECT_FALSE(answer.pose.has_value());
}

/// Recesses at both ends, 40 m of bare walls between them.
SceneBuilder bare_corridor() {
  SceneBuilder scene;
  scene.room({0.0, 0.0}, {66.0, 2.4});
  for (const double x : {2.0, 5.5, 7.2, 11.0, 54.4, 56.1, 59.9, 63.0})
    scene.box({x, 0.15}, {0.6, 0.3}).box({x + 1.3, 2.3}, {0.9, 0.2});
  return scene;
}

TEST(LocalizerTracking, APoseThatABareCorridorDoesNotHoldIsGivenUp) {
  const std::vector<Point2> points = {{1.0, 1.2}, {64.0, 1.2}};
  const Robot robot{.lidar = {.beams = 360, .range_max_m = 8.0, .noise_m = 0.01},
                    .has_odometry = false};
  const std::vector<Moment> moments =
      drive(bare_corridor(), robot, testing::route(points, 0.15), 14);
  const LocalizationMapPtr map = testing::make_map(bare_corridor(), {33.0, 1.2});
  const std::vector<Answer> answers = answers_of({map}, with(Method::kIndexed), moments);
  EXPECT_EQ(count_wrong(answers, moments, 0.5), 0U);
  const auto given_up = std::ranges::find_if(answers, [](const Answer& answer) {
    return answer.withdrawal == Withdrawal::kScansLost && answer.reason == Reason::kFewEvidence;
  });
  ASSERT_NE(given_up, answers.end());
  const double x = moments[static_cast<std::size_t>(given_up - answers.begin())].T_map_base_link.x;
  EXPECT_GT(x, 13.0);
  EXPECT_LT(x, 53.0);
}

/// Into the bare part of the corridor, with a scan per 5 cm. There the robot brakes and stands for
/// 200 scans.
std::vector<Moment> drive_and_stand_in_bare_corridor() {
  const std::vector<Point2> points = {{1.0, 1.2}, {26.0, 1.2}};
  std::vector<Pose2> poses = testing::route(points, 0.05);
  for (const double step_m : {0.04, 0.03, 0.02, 0.015, 0.01, 0.005})
    poses.push_back(poses.back() * Pose2{step_m, 0.0, 0.0});
  poses.insert(poses.end(), 200, poses.back());
  const Robot robot{.lidar = {.beams = 360, .range_max_m = 8.0, .noise_m = 0.01}};
  return drive(bare_corridor(), robot, poses, 14);
}

TEST(LocalizerTracking, OdometryHoldsAPoseInABareCorridor) {
  const std::vector<Moment> moments = drive_and_stand_in_bare_corridor();
  const LocalizationMapPtr map = testing::make_map(bare_corridor(), {33.0, 1.2});
  const std::vector<Answer> answers = answers_of({map}, with(Method::kIndexed), moments);
  EXPECT_EQ(count_wrong(answers, moments, 0.5), 0U);
  EXPECT_TRUE(std::ranges::none_of(
      answers, [](const Answer& answer) { return answer.withdrawal != Withdrawal::kNone; }));
  EXPECT_EQ(answers.back().status, Status::kLocalized);
}

}  // namespace
}  // namespace cornerfix

#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "unit/core/localizer/localizer_runs.hpp"

namespace cornerfix {
namespace {

using namespace localizer_tests;

// --- Known pose in, same pose out

class LocalizerWithMethod : public ::testing::TestWithParam<std::tuple<Method, bool>> {};

TEST_P(LocalizerWithMethod, FindsTheRobotInRandomRooms) {
  const auto [method, has_odometry] = GetParam();
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const std::vector<Moment> moments = room_drive(seed, 60, {.has_odometry = has_odometry});
    Localizer localizer({room_map(seed)}, with(method));
    const std::vector<Answer> answers = answers_until_fixed(localizer, moments);
    EXPECT_EQ(count_wrong(answers, moments), 0U);
    expect_localized_at(answers.back(), moments[answers.size() - 1].T_map_base_link);
  }
}

INSTANTIATE_TEST_SUITE_P(Localizer, LocalizerWithMethod,
                         ::testing::Combine(::testing::ValuesIn(kMethods), ::testing::Bool()),
                         [](const auto& test) {
                           return std::string(to_string(std::get<0>(test.param))) +
                                  (std::get<1>(test.param) ? "_odometry" : "_alone");
                         });

class LocalizerWithLidar : public ::testing::TestWithParam<testing::Lidar> {};

TEST_P(LocalizerWithLidar, FindsTheRobot) {
  const std::vector<Moment> moments = room_drive(2, 60, {.lidar = GetParam()});
  const std::vector<Answer> answers = answers_of({room_map(2)}, with(Method::kIndexed), moments);
  EXPECT_EQ(count_wrong(answers, moments), 0U);
  expect_localized_at(answers.back(), moments.back().T_map_base_link);
}

INSTANTIATE_TEST_SUITE_P(
    Localizer, LocalizerWithLidar,
    ::testing::Values(testing::Lidar{.beams = 180, .field_of_view_rad = kPi, .noise_m = 0.02},
                      testing::Lidar{.beams = 181, .field_of_view_rad = kPi, .range_max_m = 8.0},
                      testing::Lidar{.beams = 360, .range_max_m = 4.0, .noise_m = 0.01},
                      testing::Lidar{.beams = 1081, .field_of_view_rad = 1.5 * kPi},
                      testing::Lidar{.beams = 2000, .range_max_m = 80.0, .noise_m = 0.03}));

TEST(Localizer, FindsARobotWhoseLaserIsMountedElsewhere) {
  for (const Pose2& T_base_link_laser :
       {Pose2{0.3, -0.2, 0.0}, Pose2{0.2, 0.1, kPi / 2.0}, Pose2{-0.4, 0.0, kPi}}) {
    const std::vector<Moment> moments = room_drive(3, 12, {.T_base_link_laser = T_base_link_laser});
    const std::vector<Answer> answers = answers_of({room_map(3)}, with(Method::kIndexed), moments);
    EXPECT_EQ(count_wrong(answers, moments), 0U);
    expect_localized_at(answers.back(), moments.back().T_map_base_link);
  }
}

TEST(Localizer, ALidarThatIsMountedUpsideDownIsNotTrusted) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    std::vector<Moment> moments = room_drive(seed, 16);
    for (Moment& moment : moments) std::ranges::reverse(moment.scan.scan.ranges);
    const auto answers = answers_of({room_map(seed)}, with(Method::kIndexed), moments);
    EXPECT_EQ(count(answers, Status::kLocalized), 0U) << "seed " << seed;
  }
}

TEST(Localizer, FindsTheRobotAmongThingsTheMapDoesNotKnow) {
  const SceneBuilder today =
      testing::random_room(5).box({1.5, 0.5}, {0.5, 0.5}, 0.3).box({-1.2, -1.6}, {0.4, 0.6}, 1.0);
  const std::vector<Moment> moments = drive(today, {}, testing::wander(today, {0, 0, 0.5}, 25), 5);
  const std::vector<Answer> answers = answers_of({room_map(5)}, with(Method::kIndexed), moments);
  EXPECT_EQ(count_wrong(answers, moments), 0U);
  expect_localized_at(answers.back(), moments.back().T_map_base_link);
}

TEST(Localizer, FollowsTheRobotThroughRooms) {
  const SceneBuilder offices = testing::offices();
  const std::vector<Moment> moments = drive(offices, {}, testing::drive_through_offices(), 1);
  const std::vector<Answer> answers =
      answers_of({testing::make_map(offices, {1.0, 1.0})}, with(Method::kIndexed), moments);
  EXPECT_EQ(count_wrong(answers, moments, kRightMetres, kRightRadians), 0U);
  EXPECT_GT(count(answers, Status::kLocalized), answers.size() / 2);
  EXPECT_EQ(count(answers, Status::kLost), 0U);
}

/// Laying the map elsewhere lays the answer there, as exactly as its cells allow.
TEST(Localizer, MovingTheMapMovesTheAnswer) {
  std::vector<PosedScan> scans = testing::mapping_scans(testing::random_room(6), {0.0, 0.0});
  const auto map_moved_by = [&](const Pose2& T) {
    std::vector<PosedScan> moved = scans;
    for (PosedScan& scan : moved) scan.T_map_base_link = T * scan.T_map_base_link;
    return std::make_shared<const LocalizationMap>("map", 1, testing::map_content(moved));
  };
  const std::vector<Moment> moments = room_drive(6, 12);
  for (const Pose2& T :
       {Pose2{}, Pose2{100.0, -50.0, 0.0}, Pose2{-3.0, 8.0, kPi / 2.0}, Pose2{5.5, 2.2, -2.0}}) {
    const std::vector<Answer> answers =
        answers_of({map_moved_by(T)}, with(Method::kIndexed), moments);
    expect_localized_at(answers.back(), T * moments.back().T_map_base_link);
  }
}

TEST(Localizer, AResetForgetsAll) {
  const std::vector<Moment> moments = room_drive(13, 12);
  Localizer used({room_map(13)}, with(Method::kIndexed));
  ASSERT_EQ(answers_of(used, moments).back().status, Status::kLocalized);
  used.reset();
  EXPECT_FALSE(used.last_stamp().has_value());
  Localizer fresh(used.maps(), with(Method::kIndexed));
  for (const Moment& moment : moments) {
    expect_same(used.process(moment.scan), fresh.process(moment.scan));
  }
}

}  // namespace
}  // namespace cornerfix

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

TEST(Localizer, FindsARobotWithOdometryThatIsTenPerCentOff) {
  for (const double scale : {0.9, 1.1}) {
    const std::vector<Moment> moments = room_drive(4, 30, {.odometry_scale = scale});
    const std::vector<Answer> answers = answers_of({room_map(4)}, with(Method::kIndexed), moments);
    EXPECT_EQ(count_wrong(answers, moments), 0U);
    expect_localized_at(answers.back(), moments.back().T_map_base_link);
  }
}

TEST(Localizer, FindsARobotWhoseWheelsSlipped) {
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

TEST(Localizer, FindsARobotWhoseScansAreLostOnTheWay) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 random(seed);
    std::vector<Moment> moments = room_drive(seed, 60);
    std::erase_if(moments, [&](const Moment&) { return random() % 3 != 0; });
    const auto answers = answers_of({room_map(seed)}, with(Method::kIndexed), moments);
    EXPECT_EQ(count_wrong(answers, moments), 0U) << "seed " << seed;
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

// --- Knowing that it does not know

TEST(Localizer, ASymmetricRoomIsAmbiguous) {
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

TEST(Localizer, AnAmbiguousAnswerNamesBothPlaces) {
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

TEST(Localizer, AForeignRoomIsCollecting) {
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

TEST(Localizer, OneOfTwoIdenticalRoomsIsNeverTakenForTheOther) {
  const auto map = twin_rooms(7);
  for (const Method method : kMethods) {
    const std::vector<Moment> moments = room_drive(7, 12);
    const std::vector<Answer> answers = answers_of({map}, with(method), moments);
    SCOPED_TRACE(to_string(method));
    EXPECT_EQ(count(answers, Status::kLocalized), 0U);
    EXPECT_GT(count(answers, Status::kAmbiguous), 0U);
  }
}

TEST(Localizer, IdenticalRoomsOfOneOfManyMapsAreToldApartNoBetter) {
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

TEST(Localizer, AMirroredMapIsAForeignOne) {
  for (std::uint64_t seed = 8; seed <= 13; ++seed) {
    const LocalizationMapPtr map =
        testing::make_map(mirrored(testing::random_room(seed)), {0.0, 0.0});
    const std::vector<Answer> answers =
        answers_of({map}, with(method_for(seed)), room_drive(seed, 12));
    EXPECT_EQ(count(answers, Status::kLocalized), 0U) << "seed " << seed;
  }
}

// --- Losing and finding

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

TEST(Localizer, ARobotThatWasCarriedIsLostAndFoundAgain) {
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

TEST(Localizer, WhatIsLostStaysLostInAForeignRoom) {
  const std::vector<Moment> home = room_drive(12, 12);
  Localizer localizer({room_map(12)}, with(Method::kIndexed));
  ASSERT_EQ(answers_of(localizer, home).back().status, Status::kLocalized);
  std::vector<Moment> away = room_drive(32, 30);
  for (Moment& moment : away) moment.scan.scan.stamp += 100.0;
  const std::vector<Answer> answers = answers_of(localizer, away);
  EXPECT_EQ(answers.back().status, Status::kLost);
  EXPECT_NE(answers.back().reason, Reason::kNone);
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

#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <numbers>
#include <random>
#include <tuple>

#include "support/floor_plans.hpp"
#include "support/map_maker.hpp"
#include "support/matchers.hpp"
#include "support/simulated_drive.hpp"

namespace cornerfix {
namespace {

using testing::drive;
using testing::IsPoseNear;
using testing::Moment;
using testing::Robot;
using testing::SceneBuilder;

constexpr double kPi = std::numbers::pi;
constexpr double kRightMetres = 0.15;
constexpr double kRightRadians = 0.03;
constexpr Method kMethods[] = {Method::kRma, Method::kNma, Method::kIndexed};

LocalizerParams with(Method method) {
  LocalizerParams params;
  params.method = method;
  return params;
}

/// All methods in turn.
Method method_for(std::uint64_t seed) { return kMethods[seed % std::size(kMethods)]; }

LocalizationMapPtr room_map(std::uint64_t seed) {
  return testing::make_map(testing::random_room(seed), {0.0, 0.0});
}

/// A run about the middle of random_room(seed) from a pose that `seed` draws.
std::vector<Moment> room_drive(std::uint64_t seed, std::size_t count, const Robot& robot = {}) {
  const SceneBuilder room = testing::random_room(seed);
  std::mt19937_64 random(seed + 1000);
  std::uniform_real_distribution<double> position(-0.8, 0.8), yaw(-kPi, kPi);
  const Pose2 start{position(random), position(random), yaw(random)};
  return drive(room, robot, testing::wander(room, start, count), seed);
}

std::vector<Answer> answers_of(Localizer& localizer, const std::vector<Moment>& moments) {
  std::vector<Answer> answers;
  for (const Moment& moment : moments) {
    answers.push_back(localizer.process(moment.scan));
    const Answer& answer = answers.back();
    EXPECT_EQ(answer.pose.has_value(), answer.status == Status::kLocalized);
    EXPECT_GE(answer.confidence, 0.0);
    EXPECT_LE(answer.confidence, 1.0);
  }
  return answers;
}

std::vector<Answer> answers_of(std::vector<LocalizationMapPtr> maps, const LocalizerParams& params,
                               const std::vector<Moment>& moments) {
  Localizer localizer(std::move(maps), params);
  return answers_of(localizer, moments);
}

std::size_t count(const std::vector<Answer>& answers, Status status) {
  return static_cast<std::size_t>(std::ranges::count(answers, status, &Answer::status));
}

/// Answers that give a pose that is not the true one.
std::size_t count_wrong(const std::vector<Answer>& answers, const std::vector<Moment>& moments,
                        double metres = 0.3, double radians = 0.1) {
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (!answers[i].pose) continue;
    const Pose2& pose = answers[i].pose->T_map_base_link;
    const bool right = distance(pose, moments[i].T_map_base_link) <= metres &&
                       angle_between(pose, moments[i].T_map_base_link) <= radians;
    wrong += right ? 0 : 1;
  }
  return wrong;
}

void expect_localized_at(const Answer& answer, const Pose2& truth) {
  ASSERT_EQ(answer.status, Status::kLocalized) << to_string(answer.reason);
  EXPECT_THAT(answer.pose->T_map_base_link, IsPoseNear(truth, kRightMetres, kRightRadians));
}

/// All that can be compared of two answers but times.
void expect_same(const Answer& actual, const Answer& expected) {
  EXPECT_EQ(to_string(actual.status), to_string(expected.status));
  EXPECT_EQ(to_string(actual.reason), to_string(expected.reason));
  EXPECT_EQ(actual.confidence, expected.confidence);
  EXPECT_EQ(actual.local_scans, expected.local_scans);
  EXPECT_EQ(actual.local_features, expected.local_features);
  EXPECT_EQ(actual.T_submap_base_link, expected.T_submap_base_link);
  ASSERT_EQ(actual.pose.has_value(), expected.pose.has_value());
  if (actual.pose) {
    EXPECT_EQ(actual.pose->T_map_base_link, expected.pose->T_map_base_link);
    EXPECT_EQ(actual.pose->covariance, expected.pose->covariance);
  }
  ASSERT_EQ(actual.hypotheses.size(), expected.hypotheses.size());
  for (std::size_t i = 0; i < actual.hypotheses.size(); ++i) {
    EXPECT_EQ(actual.hypotheses[i].T_map_base_link, expected.hypotheses[i].T_map_base_link);
    EXPECT_EQ(actual.hypotheses[i].score, expected.hypotheses[i].score);
  }
}

/// The same up to what is made anew after a restart: hypotheses, and the field that scans are
/// matched on, which no longer shows the walls of forgotten scans.
void expect_alike(const Answer& actual, const Answer& expected) {
  EXPECT_EQ(to_string(actual.status), to_string(expected.status));
  EXPECT_EQ(to_string(actual.reason), to_string(expected.reason));
  EXPECT_NEAR(actual.confidence, expected.confidence, 0.05);
  EXPECT_EQ(actual.local_scans, expected.local_scans);
  EXPECT_THAT(actual.T_submap_base_link, IsPoseNear(expected.T_submap_base_link, 0.01, 0.005));
  ASSERT_EQ(actual.pose.has_value(), expected.pose.has_value());
  if (!actual.pose) return;
  EXPECT_THAT(actual.pose->T_map_base_link,
              IsPoseNear(expected.pose->T_map_base_link, 0.02, 0.005));
}

SceneBuilder mirrored(const SceneBuilder& scene) {
  SceneBuilder result;
  for (const testing::Wall& wall : scene.walls()) {
    result.wall({wall.a.x(), -wall.a.y()}, {wall.b.x(), -wall.b.y()});
  }
  return result;
}

/// Drives until a few scans after it is first localized.
std::vector<Answer> answers_until_fixed(Localizer& localizer, const std::vector<Moment>& moments) {
  std::vector<Answer> answers;
  for (const Moment& moment : moments) {
    answers.push_back(answers_of(localizer, {moment}).front());
    if (count(answers, Status::kLocalized) > 3) break;
  }
  return answers;
}

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

// --- Scans that say nothing

constexpr float kNoReturn = std::numeric_limits<float>::quiet_NaN();

struct OddScan {
  const char* name;
  std::vector<float> ranges;
};

void PrintTo(const OddScan& odd, std::ostream* out) { *out << odd.name; }

class LocalizerWithOddScans : public ::testing::TestWithParam<OddScan> {};

RobotScan odd_scan(const std::vector<float>& ranges, double stamp) {
  return {{.stamp = stamp,
           .angle_min = -kPi,
           .angle_increment = 2.0 * kPi / 360.0,
           .range_min = 0.1,
           .range_max = 30.0,
           .ranges = ranges},
          {},
          {}};
}

TEST_P(LocalizerWithOddScans, IsCollectingWithAReason) {
  const LocalizationMapPtr map = room_map(16);
  for (const Method method : kMethods) {
    Localizer localizer({map}, with(method));
    for (int i = 0; i < 8; ++i) {
      RobotScan scan = odd_scan(GetParam().ranges, 1.0 + i);
      if (i % 2 == 0) scan.T_odom_base_link = Pose2{0.3 * i, 0.0, 0.1 * i};
      const Answer answer = localizer.process(scan);
      EXPECT_EQ(answer.status, Status::kCollecting) << to_string(method) << ", scan " << i;
      EXPECT_NE(answer.reason, Reason::kNone) << to_string(method) << ", scan " << i;
      EXPECT_FALSE(answer.pose.has_value());
    }
  }
}

TEST_P(LocalizerWithOddScans, DoesNotMisleadOneThatIsLocalized) {
  const std::vector<Moment> moments = room_drive(16, 20);
  Localizer localizer({room_map(16)}, with(Method::kIndexed));
  const std::vector<Moment> before(moments.begin(), moments.begin() + 12);
  const std::vector<Moment> after(moments.begin() + 12, moments.end());
  ASSERT_EQ(answers_of(localizer, before).back().status, Status::kLocalized);
  RobotScan odd = odd_scan(GetParam().ranges, before.back().scan.scan.stamp + 0.1);
  odd.T_odom_base_link = before.back().scan.T_odom_base_link;
  const Answer answer = localizer.process(odd);
  if (answer.pose) {
    EXPECT_THAT(answer.pose->T_map_base_link, IsPoseNear(before.back().T_map_base_link, 0.3, 0.1));
  }
  const std::vector<Answer> answers = answers_of(localizer, after);
  EXPECT_EQ(count_wrong(answers, after), 0U);
  expect_localized_at(answers.back(), after.back().T_map_base_link);
}

INSTANTIATE_TEST_SUITE_P(Localizer, LocalizerWithOddScans,
                         ::testing::Values(OddScan{"no_beams", {}}, OddScan{"one_beam", {2.0F}},
                                           OddScan{"two_beams", {2.0F, 2.1F}},
                                           OddScan{"all_null", std::vector<float>(360, kNoReturn)},
                                           OddScan{"all_zero", std::vector<float>(360, 0.0F)},
                                           OddScan{"all_too_far", std::vector<float>(360, 31.0F)},
                                           OddScan{"all_equal", std::vector<float>(360, 2.0F)},
                                           OddScan{"all_equal_and_far",
                                                   std::vector<float>(360, 25.0F)}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Localizer, APoseIsTakenBackWhenTheLidarIsCoveredOnTheWay) {
  const std::vector<Moment> moments = room_drive(1, 60);
  Localizer localizer({room_map(1)}, with(Method::kIndexed));
  std::size_t i = 0;
  while (i < 20) (void)localizer.process(moments[i++].scan);
  ASSERT_EQ(localizer.state().status, Status::kLocalized);
  Answer answer;
  for (; i < moments.size(); ++i) {
    RobotScan blind = moments[i].scan;
    std::ranges::fill(blind.scan.ranges, kNoReturn);
    answer = localizer.process(blind);
  }
  EXPECT_EQ(answer.status, Status::kLost);
  EXPECT_EQ(answer.reason, Reason::kNoReturns);
  EXPECT_FALSE(answer.pose.has_value());
}

TEST(Localizer, ACoveredLidarIsNeverLocalized) {
  const LocalizationMapPtr map = room_map(16);
  for (const Method method : kMethods) {
    Localizer localizer({map}, with(method));
    for (int i = 0; i < 8; ++i) {
      RobotScan scan = odd_scan(std::vector<float>(360, 0.1F), 1.0 + i);
      scan.T_odom_base_link = Pose2{0.3 * i, 0.0, 0.1 * i};
      EXPECT_NE(localizer.process(scan).status, Status::kLocalized) << to_string(method);
    }
  }
}

TEST(Localizer, WithoutAnyReturnTheReasonIsThat) {
  Localizer localizer({room_map(16)}, with(Method::kRma));
  const Answer answer = localizer.process(odd_scan(std::vector<float>(360, kNoReturn), 1.0));
  EXPECT_EQ(answer.reason, Reason::kNoReturns);
}

// --- The rest of an answer

TEST(Localizer, CovarianceIsSymmetricAndPositive) {
  const std::vector<Answer> answers =
      answers_of({room_map(17)}, with(Method::kIndexed), room_drive(17, 15));
  ASSERT_EQ(answers.back().status, Status::kLocalized);
  for (const Answer& answer : answers) {
    if (!answer.pose) continue;
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> covariance(
        answer.pose->covariance.data());
    EXPECT_LT((covariance - covariance.transpose()).norm(), 1e-12);
    EXPECT_EQ(Eigen::LLT<Eigen::Matrix3d>(covariance).info(), Eigen::Success);
    EXPECT_LT(std::sqrt(covariance(0, 0)), 0.2);
    EXPECT_LT(std::sqrt(covariance(1, 1)), 0.2);
    EXPECT_LT(std::sqrt(covariance(2, 2)), 0.1);
  }
}

TEST(Localizer, ALocalizedAnswerNamesItsPlaceFirst) {
  const Answer answer =
      answers_of({room_map(17)}, with(Method::kIndexed), room_drive(17, 15)).back();
  ASSERT_TRUE(answer.pose.has_value());
  ASSERT_FALSE(answer.hypotheses.empty());
  EXPECT_EQ(answer.hypotheses.front().T_map_base_link, answer.pose->T_map_base_link);
  EXPECT_EQ(answer.hypotheses.front().map, answer.pose->map);
  EXPECT_GT(answer.hypotheses.front().score, 0.5);
  EXPECT_EQ(answer.reason, Reason::kNone);
}

TEST(Localizer, HypothesesComeBestFirstAndAreScored) {
  const SceneBuilder room = SceneBuilder().room({-4, -2.5}, {4, 2.5});
  const std::vector<Moment> moments =
      drive(room, {}, testing::wander(room, {1.0, 0.3, 1.0}, 10), 1);
  for (const Answer& answer :
       answers_of({testing::make_map(room, {0.0, 0.0})}, with(Method::kIndexed), moments)) {
    for (const RankedHypothesis& hypothesis : answer.hypotheses) {
      EXPECT_GE(hypothesis.score, 0.0);
      EXPECT_LE(hypothesis.score, 1.0);
      EXPECT_NE(hypothesis.map, nullptr);
    }
  }
}

TEST(Localizer, TellsItsSubmap) {
  const std::vector<Moment> moments = room_drive(18, 15);
  Localizer localizer({}, {});
  const Answer answer = answers_of(localizer, moments).back();
  EXPECT_GT(answer.local_scans, 5);
  EXPECT_GT(answer.local_features, 3);
  EXPECT_EQ(localizer.local_features_base_link().size(),
            static_cast<std::size_t>(answer.local_features));
  EXPECT_THAT(answer.T_submap_base_link,
              IsPoseNear(inverse(moments.front().T_map_base_link) * moments.back().T_map_base_link,
                         0.1, 0.03));
  EXPECT_EQ(localizer.last_stamp(), moments.back().scan.scan.stamp);
}

TEST(Localizer, TimesItsStepsByTheClockItIsGiven) {
  double now = 0.0;
  Localizer timed({}, {}, [&now] { return now += 1.0; });
  const Answer answer = timed.process(room_drive(18, 1).front().scan);
  EXPECT_GT(answer.times.odometry_ms, 0.0);
  EXPECT_GT(answer.times.extract_ms, 0.0);
  EXPECT_GE(answer.times.total_ms, answer.times.odometry_ms + answer.times.extract_ms +
                                       answer.times.match_ms + answer.times.verify_ms +
                                       answer.times.track_ms);
}

TEST(Localizer, WithoutAClockTimesAreZero) {
  Localizer localizer({}, {});
  EXPECT_EQ(localizer.process(room_drive(18, 1).front().scan).times.total_ms, 0.0);
}

TEST(Localizer, NamesOnTheWire) {
  EXPECT_EQ(to_string(Status::kCollecting), "collecting");
  EXPECT_EQ(to_string(Status::kAmbiguous), "ambiguous");
  EXPECT_EQ(to_string(Status::kLocalized), "localized");
  EXPECT_EQ(to_string(Status::kLost), "lost");
  EXPECT_EQ(to_string(Reason::kNone), "");
  EXPECT_EQ(to_string(Reason::kNoReturns), "no_returns");
  EXPECT_EQ(to_string(Reason::kFewFeatures), "few_features");
  EXPECT_EQ(to_string(Reason::kNoMotion), "no_motion");
  EXPECT_EQ(to_string(Reason::kNoMatch), "no_match");
  EXPECT_EQ(to_string(Reason::kFewEvidence), "few_evidence");
  EXPECT_EQ(to_string(Reason::kContradicted), "contradicted");
}

}  // namespace
}  // namespace cornerfix

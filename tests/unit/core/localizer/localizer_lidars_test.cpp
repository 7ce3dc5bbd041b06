// Robots with several lidars, and with lidars that are mounted otherwise than declared.
#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numbers>

#include "support/floor_plans.hpp"
#include "support/map_maker.hpp"
#include "support/matchers.hpp"
#include "support/simulated_drive.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;
using testing::Moment;

using std::numbers::pi;
const Pose2 kFront{0.2, 0.1, 0.0};
const Pose2 kRear{-0.2, -0.1, pi};

/// Drives in random_room(seed). Each robot starts elsewhere.
std::vector<Pose2> path_of(std::uint64_t seed, std::size_t scans) {
  std::mt19937_64 random(seed + 1000);
  std::uniform_real_distribution<double> position(-0.8, 0.8), yaw(-pi, pi);
  const Pose2 start{position(random), position(random), yaw(random)};
  return testing::wander(testing::random_room(seed), start, scans);
}

/// What a lidar of 180 deg or 360 deg at `T_base_link_laser` sees of that.
std::vector<Moment> seen_by(const Pose2& T_base_link_laser, double field_of_view_rad,
                            std::uint64_t seed, bool has_odometry, std::size_t scans = 16) {
  const auto beams = static_cast<std::size_t>(240.0 * field_of_view_rad / (2.0 * pi));
  const testing::Robot robot{
      .lidar = {.beams = beams, .field_of_view_rad = field_of_view_rad, .noise_m = 0.01},
      .T_base_link_laser = T_base_link_laser,
      .has_odometry = has_odometry};
  return testing::drive(testing::random_room(seed), robot, path_of(seed, scans), seed);
}

/// Two lidars of 180 deg, back to back. Their scans come `apart_s` after one another.
std::vector<Moment> seen_by_two(std::uint64_t seed, bool has_odometry, double apart_s) {
  const std::vector<Moment> front = seen_by(kFront, pi, seed, has_odometry);
  const std::vector<Moment> rear = seen_by(kRear, pi, seed, has_odometry);
  std::vector<Moment> both;
  for (std::size_t i = 0; i < front.size(); ++i) {
    both.push_back(front[i]);
    both.push_back(rear[i]);
    both.back().scan.scan.stamp += apart_s;
  }
  return both;
}

struct Outcome {
  std::size_t localized = 0;  ///< Runs that ended localized at the true pose.
  std::size_t wrong = 0;      ///< Answers with a wrong pose.
  double error_m = 0.0;       ///< Sum of those localized.
};

Outcome& operator+=(Outcome& sum, const Outcome& one) {
  sum.localized += one.localized;
  sum.wrong += one.wrong;
  sum.error_m += one.error_m;
  return sum;
}

Outcome outcome_of(std::uint64_t seed, const std::vector<Moment>& moments) {
  Localizer localizer({testing::make_map(testing::random_room(seed), {0.0, 0.0})}, {});
  Outcome outcome;
  Answer answer;
  for (const Moment& moment : moments) {
    answer = localizer.process(moment.scan);
    if (answer.pose && distance(answer.pose->T_map_base_link, moment.T_map_base_link) > 0.3)
      ++outcome.wrong;
  }
  if (answer.pose) {
    ++outcome.localized;
    outcome.error_m = distance(answer.pose->T_map_base_link, moments.back().T_map_base_link);
  }
  return outcome;
}

class LocalizerWithTwoLidars : public ::testing::TestWithParam<std::tuple<bool, double>> {};

TEST_P(LocalizerWithTwoLidars, FindsTheRobotAsWithOneOfAFullTurn) {
  const auto [has_odometry, apart_s] = GetParam();
  constexpr std::uint64_t kRooms = 8;
  Outcome two;
  Outcome full;
  for (std::uint64_t seed = 1; seed <= kRooms; ++seed) {
    two += outcome_of(seed, seen_by_two(seed, has_odometry, apart_s));
    full += outcome_of(seed, seen_by({}, 2.0 * pi, seed, has_odometry));
  }
  EXPECT_EQ(full.localized, kRooms);
  EXPECT_EQ(two.localized, kRooms);
  EXPECT_EQ(two.wrong, 0U);
  EXPECT_LT(two.error_m / kRooms, std::max(0.04, 1.5 * full.error_m / kRooms));
}

INSTANTIATE_TEST_SUITE_P(Drives, LocalizerWithTwoLidars,
                         ::testing::Combine(::testing::Bool(), ::testing::Values(0.0, 0.005)));

TEST(LocalizerWithTwoLidars, TheLocalMapHoldsScansOfBoth) {
  const std::vector<Moment> moments = seen_by_two(2, true, 0.0);
  Localizer localizer({testing::make_map(testing::random_room(2), {0.0, 0.0})}, {});
  for (const Moment& moment : moments) (void)localizer.process(moment.scan);
  const LocalizerState state = localizer.state();
  const auto of = [&](const Pose2& T_base_link_laser) {
    return std::ranges::count_if(state.submap, [&](const SubmapScanPtr& scan) {
      return scan->T_base_link_laser == T_base_link_laser;
    });
  };
  EXPECT_GE(of(kFront), 3);
  EXPECT_LE(std::abs(of(kFront) - of(kRear)), 1);
}

/// Where a mirrored scan fits some other pose well, the reason stays another one.
TEST(LocalizerWithMirroredScans, SaysInMostRoomsThatTheyAreMirrored) {
  std::size_t mirrored = 0;
  constexpr std::uint64_t kRooms = 6;
  for (std::uint64_t seed = 1; seed <= kRooms; ++seed) {
    Localizer localizer({testing::make_map(testing::random_room(seed), {0.0, 0.0})}, {});
    bool says_so = false;
    for (Moment moment : seen_by({}, 2.0 * pi, seed, false, 50)) {
      moment.scan.scan.angle_min *= -1.0;
      moment.scan.scan.angle_increment *= -1.0;
      const Answer answer = localizer.process(moment.scan);
      EXPECT_FALSE(answer.pose.has_value());
      says_so |= answer.reason == Reason::kMirroredScans;
    }
    mirrored += says_so ? 1U : 0U;
  }
  EXPECT_GE(mirrored, kRooms / 2);
}

TEST(LocalizerWithMirroredScans, DoesNotSaySoOfScansThatAreNot) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Localizer here({testing::make_map(testing::random_room(seed), {0.0, 0.0})}, {});
    Localizer elsewhere({testing::make_map(testing::random_room(seed + 20), {0.0, 0.0})}, {});
    for (const Moment& moment : seen_by({}, 2.0 * pi, seed, true, 50)) {
      EXPECT_NE(here.process(moment.scan).reason, Reason::kMirroredScans) << seed;
      EXPECT_NE(elsewhere.process(moment.scan).reason, Reason::kMirroredScans) << seed;
    }
  }
}

}  // namespace
}  // namespace cornerfix

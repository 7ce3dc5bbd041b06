#include "evaluation/metrics/revisit_score.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/room_drive.hpp"

namespace cornerfix::evaluation {
namespace {

using cornerfix::testing::circle_in_room;
using cornerfix::testing::scan_in_room;
using ::testing::Each;
using ::testing::IsEmpty;
using ::testing::Lt;

constexpr double kStepRad = 0.2;

/// Three times around the room, in steps of 0.44 m: after two rounds it has gone 20 m.
struct Rounds {
  std::vector<Pose2> poses = circle_in_room(2.2, 0.0, kStepRad, 94);
  std::vector<LogScan> scans;
  std::vector<std::size_t> indices = std::vector<std::size_t>(poses.size());

  Rounds() {
    for (const Pose2& pose : poses) {
      scans.emplace_back();
      scans.back().scan = scan_in_room(pose, static_cast<double>(scans.size()));
    }
    std::iota(indices.begin(), indices.end(), std::size_t{0});
  }

  [[nodiscard]] RevisitScore score(const std::vector<std::vector<Pose2>>& trajectories) const {
    return score_revisits(scans, indices, trajectories);
  }
};

/// A trajectory that is moved from the second round on.
std::vector<Pose2> with_jump(std::vector<Pose2> poses, const Pose2& T) {
  for (std::size_t i = 32; i < poses.size(); ++i) poses[i] = T * poses[i];
  return poses;
}

TEST(RevisitScore, IsZeroForThePosesOfTheScans) {
  const Rounds rounds;
  const RevisitScore score = rounds.score({rounds.poses});
  ASSERT_EQ(score.errors.size(), 1U);
  EXPECT_GT(score.pairs, 25U);
  EXPECT_EQ(score.errors[0].errors_m.size(), score.pairs);
  EXPECT_THAT(score.errors[0].errors_m, Each(Lt(0.003)));
  EXPECT_THAT(score.errors[0].errors_rad, Each(Lt(0.002)));
}

/// Of the pairs, those across the jump, whose errors are about as large as it.
std::size_t count_about(const std::vector<double>& errors_m, double jump_m) {
  return static_cast<std::size_t>(std::ranges::count_if(
      errors_m, [&](double m) { return std::abs(m - jump_m) < 0.1 * jump_m; }));
}

TEST(RevisitScore, FindsWhichOfTwoTrajectoriesTheScansSpeakFor) {
  const Rounds rounds;
  for (const double jump_m : {0.1, 1.0, 3.0}) {
    const std::vector<Pose2> wrong = with_jump(rounds.poses, {jump_m, 0.0, 0.0});
    for (const bool wrong_is_first : {true, false}) {
      const RevisitScore score = wrong_is_first ? rounds.score({wrong, rounds.poses})
                                                : rounds.score({rounds.poses, wrong});
      ASSERT_EQ(score.errors.size(), 2U);
      EXPECT_GT(count_about(score.errors[wrong_is_first ? 0 : 1].errors_m, jump_m), 20U) << jump_m;
      EXPECT_THAT(score.errors[wrong_is_first ? 1 : 0].errors_m, Each(Lt(0.01))) << jump_m;
    }
  }
}

TEST(RevisitScore, JudgesEveryTrajectoryInItsOwnFrame) {
  const Rounds rounds;
  std::vector<Pose2> elsewhere;
  for (const Pose2& pose : rounds.poses) elsewhere.push_back(Pose2{10, -4, 2} * pose);
  const RevisitScore score = rounds.score({rounds.poses, elsewhere});
  EXPECT_GT(score.pairs, 25U);
  EXPECT_THAT(score.errors[1].errors_m, Each(Lt(0.003)));
}

TEST(RevisitScore, CountsUndecidedPairs) {
  Rounds rounds;
  for (LogScan& scan : rounds.scans) scan.scan.ranges.assign(360, 0.0F);
  const RevisitScore score = rounds.score({rounds.poses});
  EXPECT_EQ(score.pairs, 0U);
  EXPECT_GT(score.undecided, 25U);
}

TEST(RevisitScore, HasNoPairsInARunThatNeverComesBack) {
  Rounds rounds;
  for (const std::size_t scans : {31U, 0U}) {  // once around is 13 m
    rounds.indices.resize(scans);
    const RevisitScore score = rounds.score({rounds.poses});
    EXPECT_EQ(score.pairs + score.undecided, 0U);
    EXPECT_THAT(score.errors[0].errors_m, IsEmpty());
  }
}

TEST(RevisitScore, LooksAtFiveHundredPairsAtMost) {
  Rounds rounds;
  for (LogScan& scan : rounds.scans) scan.scan.ranges.assign(360, 0.0F);
  // Round and round, over the same scans.
  const std::vector<std::size_t> thrice = rounds.indices;
  rounds.scans.reserve(10 * thrice.size());
  for (int i = 1; i < 10; ++i) {
    for (const std::size_t n : thrice) {
      rounds.indices.push_back(rounds.scans.size());
      rounds.scans.push_back(rounds.scans[n]);
      rounds.poses.push_back(rounds.poses[n]);
    }
  }
  EXPECT_EQ(rounds.score({rounds.poses}).undecided, 500U);
}

}  // namespace
}  // namespace cornerfix::evaluation

#include "cli/revisit_score.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "support/room_drive.hpp"

namespace cornerfix::cli {
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

  [[nodiscard]] std::vector<RelativePoseError> errors(
      const std::vector<std::vector<Pose2>>& trajectories) const {
    return revisit_errors(scans, indices, trajectories);
  }
};

/// A trajectory that is moved from the second round on.
std::vector<Pose2> with_jump(std::vector<Pose2> poses, const Pose2& T) {
  for (std::size_t i = 32; i < poses.size(); ++i) poses[i] = T * poses[i];
  return poses;
}

TEST(RevisitScore, IsZeroForThePosesOfTheScans) {
  const Rounds rounds;
  const auto errors = rounds.errors({rounds.poses});
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_GT(errors[0].errors_m.size(), 25U);
  EXPECT_THAT(errors[0].errors_m, Each(Lt(0.003)));
  EXPECT_THAT(errors[0].errors_rad, Each(Lt(0.002)));
}

TEST(RevisitScore, FindsWhichOfTwoTrajectoriesTheScansSpeakFor) {
  const Rounds rounds;
  const auto errors = rounds.errors({with_jump(rounds.poses, {0.1, 0.0, 0.0}), rounds.poses});
  ASSERT_EQ(errors.size(), 2U);
  ASSERT_GT(errors[0].errors_m.size(), 20U);
  ASSERT_EQ(errors[0].errors_m.size(), errors[1].errors_m.size());
  for (std::size_t i = 0; i < errors[0].errors_m.size(); ++i)
    EXPECT_NEAR(errors[0].errors_m[i], 0.1, 0.005) << i;
  EXPECT_THAT(errors[1].errors_m, Each(Lt(0.005)));
}

TEST(RevisitScore, JudgesEveryTrajectoryInItsOwnFrame) {
  const Rounds rounds;
  std::vector<Pose2> elsewhere;
  for (const Pose2& pose : rounds.poses) elsewhere.push_back(Pose2{10, -4, 2} * pose);
  const auto errors = rounds.errors({rounds.poses, elsewhere});
  ASSERT_FALSE(errors[1].errors_m.empty());
  EXPECT_THAT(errors[1].errors_m, Each(Lt(0.003)));
}

TEST(RevisitScore, HasNothingToSayOfADriveThatNeverComesBack) {
  Rounds rounds;
  rounds.indices.resize(31);  // once around: 13 m
  EXPECT_THAT(rounds.errors({rounds.poses})[0].errors_m, IsEmpty());
  rounds.indices.clear();
  EXPECT_THAT(rounds.errors({rounds.poses})[0].errors_m, IsEmpty());
}

TEST(RevisitScore, JudgesAThousandPairsAtMost) {
  Rounds rounds;
  for (LogScan& log_scan : rounds.scans) {
    LaserScan& scan = log_scan.scan;
    for (std::size_t i = 0; 2 * i < scan.ranges.size(); ++i) scan.ranges[i] = scan.ranges[2 * i];
    scan.ranges.resize(scan.ranges.size() / 2);
    scan.angle_increment *= 2.0;
  }
  rounds.indices.insert(rounds.indices.end(), 2400, rounds.indices.back());  // it stands still
  const auto errors = rounds.errors({rounds.poses});
  EXPECT_LE(errors[0].errors_m.size(), 1000U);
  EXPECT_GT(errors[0].errors_m.size(), 900U);
}

}  // namespace
}  // namespace cornerfix::cli

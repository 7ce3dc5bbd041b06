#include "evaluation/metrics/trajectory_score.hpp"

#include <gtest/gtest.h>

#include "support/matchers.hpp"

namespace cornerfix::evaluation {
namespace {

using cornerfix::testing::IsPoseNear;

/// Half a metre a scan along an arc, each with its reference pose.
std::vector<LogScan> arc() {
  std::vector<LogScan> scans(21);
  Pose2 pose{3.0, 1.0, 0.4};
  for (LogScan& scan : scans) {
    scan.T_map_laser = pose;
    pose = pose * Pose2{0.5, 0.0, 0.1};
  }
  return scans;
}

std::vector<Pose2> poses_of(const std::vector<LogScan>& scans, const Pose2& T) {
  std::vector<Pose2> poses;
  for (const LogScan& scan : scans) poses.push_back(T * *scan.T_map_laser);
  return poses;
}

TEST(TrajectoryScore, IsZeroForTheReferenceInAnyFrame) {
  const std::vector<LogScan> scans = arc();
  const auto error = relative_pose_error(scans, poses_of(scans, {10, -4, 2}), 2.0);
  ASSERT_FALSE(error.errors_m.empty());
  for (const double metres : error.errors_m) EXPECT_NEAR(metres, 0.0, 1e-9);
  for (const double radians : error.errors_rad) EXPECT_NEAR(radians, 0.0, 1e-9);
}

TEST(TrajectoryScore, CountsAMistakeInTheRelationsAcrossItOnly) {
  const std::vector<LogScan> scans = arc();
  std::vector<Pose2> poses = poses_of(scans, {});
  for (std::size_t i = 10; i < poses.size(); ++i) poses[i] = Pose2{0.3, 0.0, 0.0} * poses[i];
  const auto error = relative_pose_error(scans, poses, 0.4);  // from scan to scan
  ASSERT_EQ(error.errors_m.size(), 20U);
  for (std::size_t i = 0; i < 20; ++i)
    EXPECT_NEAR(error.errors_m[i], i == 9 ? 0.3 : 0.0, 1e-9) << i;
}

TEST(TrajectoryScore, DistinguishesTurnsFromShifts) {
  const std::vector<LogScan> scans = arc();
  std::vector<Pose2> poses = poses_of(scans, {});
  poses[20].yaw += 0.2;
  const auto error = relative_pose_error(scans, poses, 0.4);
  EXPECT_NEAR(error.errors_m.back(), 0.0, 1e-9);
  EXPECT_NEAR(error.errors_rad.back(), 0.2, 1e-9);
}

TEST(TrajectoryScore, JudgesByKeyScansWhereALogMarksThem) {
  std::vector<LogScan> scans = arc();
  scans[0].is_key_scan = scans[20].is_key_scan = true;
  EXPECT_EQ(relative_pose_error(scans, poses_of(scans, {}), 2.0).errors_m.size(), 1U);
  EXPECT_EQ(reference_scans(scans), (std::vector<std::size_t>{0, 20}));
}

TEST(TrajectoryScore, HasNoRelationsLongerThanThePath) {
  const std::vector<LogScan> scans = arc();
  EXPECT_TRUE(relative_pose_error(scans, poses_of(scans, {}), 50.0).errors_m.empty());
}

TEST(TrajectoryScore, AlignsATrajectoryWithTheReference) {
  const std::vector<LogScan> scans = arc();
  const Pose2 T_any_map{4.0, -7.0, 2.5};
  EXPECT_THAT(align_to_reference(scans, poses_of(scans, T_any_map)),
              IsPoseNear(inverse(T_any_map), 1e-9, 1e-9));
}

TEST(TrajectoryScore, AlignsNothingWithoutAReference) {
  EXPECT_EQ(align_to_reference(std::vector<LogScan>(3), std::vector<Pose2>(3)), Pose2{});
}

}  // namespace
}  // namespace cornerfix::evaluation

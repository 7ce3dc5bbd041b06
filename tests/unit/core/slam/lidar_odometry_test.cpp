#include <gtest/gtest.h>

#include <cornerfix/slam.hpp>
#include <limits>

#include "support/floor_plans.hpp"
#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;
using testing::Moment;

std::vector<Moment> moments_with(const testing::Robot& robot, double step_m = 0.2) {
  return testing::drive(testing::offices(), robot,
                        testing::drive_through_offices(step_m, 0.5 * step_m), 3);
}

/// The pose after each scan.
std::vector<Pose2> poses_of(const std::vector<Moment>& moments) {
  LidarOdometry odometry;
  std::vector<Pose2> poses;
  for (const Moment& moment : moments) poses.push_back(odometry.process(moment.scan));
  return poses;
}

Pose2 expected(const std::vector<Moment>& moments, std::size_t i) {
  return inverse(moments.front().T_map_base_link) * moments[i].T_map_base_link;
}

TEST(LidarOdometry, BeginsAtTheIdentity) {
  const std::vector<Moment> moments = moments_with({});
  EXPECT_THAT(poses_of(moments).front(), IsPoseNear(Pose2{}, 0.0, 0.0));
}

TEST(LidarOdometry, GoesOnBehindScansWhoseGeometryIsNotFinite) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Moment> moments = moments_with({});
  ASSERT_GT(moments.size(), 20U);
  moments[5].scan.scan.angle_min = kNan;
  moments[6].scan.scan.angle_increment = kNan;
  moments[7].scan.T_base_link_laser.x = kNan;
  const std::vector<Pose2> poses = poses_of(moments);
  EXPECT_THAT(poses.back(), IsPoseNear(expected(moments, poses.size() - 1), 0.3, 0.05));
}

TEST(LidarOdometry, MendsAnOdometryThatTellsATenthTooMuch) {
  const std::vector<Moment> moments = moments_with({.odometry_scale = 1.1});
  const std::vector<Pose2> poses = poses_of(moments);
  for (std::size_t i = 0; i < poses.size(); ++i)
    ASSERT_THAT(poses[i], IsPoseNear(expected(moments, i), 0.15, 0.03)) << "scan " << i;
}

TEST(LidarOdometry, NeedsNoOdometry) {
  const std::vector<Moment> moments = moments_with({.has_odometry = false});
  const std::vector<Pose2> poses = poses_of(moments);
  for (std::size_t i = 0; i < poses.size(); ++i)
    ASSERT_THAT(poses[i], IsPoseNear(expected(moments, i), 0.15, 0.03)) << "scan " << i;
}

TEST(LidarOdometry, BearsAnOdometryThatStandsStillAndThenJumps) {
  std::vector<Moment> moments = moments_with({});
  for (std::size_t i = 11; i < 15; ++i)
    moments[i].scan.T_odom_base_link = moments[10].scan.T_odom_base_link;
  const std::vector<Pose2> poses = poses_of(moments);
  EXPECT_THAT(poses[14], IsPoseNear(expected(moments, 14), 0.15, 0.03));
  EXPECT_THAT(poses.back(), IsPoseNear(expected(moments, moments.size() - 1), 0.15, 0.03));
}

/// A counter that began again, or overflowed: its value for that one step is no motion.
TEST(LidarOdometry, BearsAnOdometryThatBeginsAnew) {
  for (const double offset : {30.0, 800.0, 1e8}) {
    std::vector<Moment> moments = moments_with({});
    for (std::size_t i = 20; i < moments.size(); ++i)
      moments[i].scan.T_odom_base_link =
          Pose2{offset, -offset, 2.0} * *moments[i].scan.T_odom_base_link;
    const std::vector<Pose2> poses = poses_of(moments);
    EXPECT_THAT(poses[20], IsPoseNear(expected(moments, 20), 0.15, 0.03)) << offset;
    EXPECT_THAT(poses.back(), IsPoseNear(expected(moments, moments.size() - 1), 0.15, 0.03))
        << offset;
  }
}

TEST(LidarOdometry, BearsRangesFarBeyondAnyBuilding) {
  std::vector<Moment> moments = moments_with({});
  for (Moment& moment : moments) {
    moment.scan.scan.range_max = 3.4e38;
    moment.scan.scan.ranges[90] = 3e9F;
  }
  EXPECT_THAT(poses_of(moments).back(),
              IsPoseNear(expected(moments, moments.size() - 1), 0.15, 0.03));
}

TEST(LidarOdometry, FindsTheRightMountedLaser) {
  const std::vector<Moment> moments = moments_with({.T_base_link_laser = {0.3, -0.1, 0.5}});
  EXPECT_THAT(poses_of(moments).back(),
              IsPoseNear(expected(moments, moments.size() - 1), 0.15, 0.03));
}

TEST(LidarOdometry, FollowsOdometryWhereTheLidarSeesNothing) {
  std::vector<Moment> moments = moments_with({});
  for (Moment& moment : moments)
    std::ranges::fill(moment.scan.scan.ranges, std::numeric_limits<float>::quiet_NaN());
  EXPECT_THAT(poses_of(moments).back(),
              IsPoseNear(expected(moments, moments.size() - 1), 1e-6, 1e-6));
}

TEST(LidarOdometry, GoesOnFromATrack) {
  const std::vector<Moment> moments = moments_with({});
  const std::vector<Pose2> poses = poses_of(moments);
  const std::size_t half = moments.size() / 2;
  std::vector<PosedScan> track;
  for (std::size_t i = 0; i < half; ++i)
    track.push_back({moments[i].scan.scan, moments[i].scan.T_base_link_laser, poses[i]});
  LidarOdometry odometry;
  odometry.resume(track);
  for (std::size_t i = half; i < moments.size(); ++i)
    ASSERT_THAT(odometry.process(moments[i].scan), IsPoseNear(poses[i], 0.1, 0.02)) << i;
}

}  // namespace
}  // namespace cornerfix

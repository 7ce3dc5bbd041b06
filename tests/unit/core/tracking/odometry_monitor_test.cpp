#include "core/src/tracking/odometry_monitor.hpp"

#include <gtest/gtest.h>

namespace cornerfix {
namespace {

const Eigen::Matrix3d kConstrained = Eigen::Vector3d{2e4, 2e4, 1e5}.asDiagonal();
const Eigen::Matrix3d kCorridor = Eigen::Vector3d{1.0, 2e4, 1e5}.asDiagonal();  // along x
const Pose2 kTrueStep{0.08, 0.0, 0.0};

OdometryMonitor after(int scans, const Pose2& odometry, const Pose2& matched,
                      const Eigen::Matrix3d& information, OdometryMonitor monitor = {}) {
  for (int i = 0; i < scans; ++i) monitor.add(odometry, matched, information);
  return monitor;
}

TEST(OdometryMonitor, BeginsTrusted) {
  EXPECT_EQ(OdometryMonitor().use(), OdometryUse::kUsed);
  EXPECT_EQ(OdometryMonitor().noise_scale(), Eigen::Vector3d::Ones());
}

TEST(OdometryMonitor, UsesOdometryThatAgreesWithTheScans) {
  EXPECT_EQ(after(50, kTrueStep, {0.083, 0.001, 0.002}, kConstrained).use(), OdometryUse::kUsed);
}

TEST(OdometryMonitor, IgnoresOdometryThatNeverChanges) {
  EXPECT_EQ(after(10, {}, kTrueStep, kConstrained).use(), OdometryUse::kIgnored);
}

TEST(OdometryMonitor, IgnoresAWrongHeading) {
  EXPECT_EQ(after(10, {0.0, 0.08, 0.0}, kTrueStep, kConstrained).use(), OdometryUse::kIgnored);
}

TEST(OdometryMonitor, CannotJudgeMotionAlongABareCorridor) {
  // The match follows the prediction where the scans do not constrain it.
  EXPECT_EQ(after(50, {}, {0.0, 0.001, 0.0}, kCorridor).use(), OdometryUse::kUsed);
}

TEST(OdometryMonitor, DistrustLastsThroughABareCorridor) {
  const OdometryMonitor before = after(10, {}, kTrueStep, kConstrained);
  const OdometryMonitor later = after(200, {}, {0.0, 0.001, 0.0}, kCorridor, before);
  EXPECT_EQ(later.use(), OdometryUse::kIgnored);
}

TEST(OdometryMonitor, WhatIsWrongSidewaysIsDistrustedForward) {
  // Along a corridor the match follows the prediction forward.
  const OdometryMonitor monitor = after(6, {0.06, 0.06, 0.0}, {0.06, 0.0, 0.0}, kCorridor);
  EXPECT_GT(monitor.noise_scale().y(), 1.5);
  EXPECT_EQ(monitor.noise_scale().x(), monitor.noise_scale().y());
  EXPECT_EQ(monitor.noise_scale().z(), 1.0);
}

TEST(OdometryMonitor, TakesOdometryUpAgainOnceItAgrees) {
  const OdometryMonitor before = after(10, {}, kTrueStep, kConstrained);
  EXPECT_EQ(after(60, kTrueStep, kTrueStep, kConstrained, before).use(), OdometryUse::kUsed);
}

TEST(OdometryMonitor, OneJumpIsForgottenSoon) {
  OdometryMonitor monitor = after(20, kTrueStep, kTrueStep, kConstrained);
  monitor.add({49.0, 3.0, 1.0}, kTrueStep, kConstrained);
  EXPECT_NE(monitor.use(), OdometryUse::kIgnored);
  EXPECT_GT(monitor.noise_scale().x(), 1.5);
  EXPECT_EQ(after(30, kTrueStep, kTrueStep, kConstrained, monitor).use(), OdometryUse::kUsed);
}

TEST(OdometryMonitor, OdometryThatHangsIsNotTrustedAgainWhileTheRobotStands) {
  const OdometryMonitor before = after(10, {}, kTrueStep, kConstrained);
  EXPECT_EQ(after(100, {}, {}, kConstrained, before).use(), OdometryUse::kIgnored);
}

TEST(OdometryMonitor, TheVerdictDoesNotDependOnTheScanRate) {
  const Pose2 short_step{0.01, 0.0, 0.0};
  EXPECT_EQ(after(80, {}, short_step, kConstrained).use(), OdometryUse::kIgnored);
}

TEST(OdometryMonitor, ContinuesFromItsSums) {
  const OdometryMonitor monitor = after(10, {}, kTrueStep, kConstrained);
  EXPECT_EQ(OdometryMonitor(monitor.sums()).noise_scale(), monitor.noise_scale());
}

}  // namespace
}  // namespace cornerfix

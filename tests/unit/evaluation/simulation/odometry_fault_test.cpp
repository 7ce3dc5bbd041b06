#include "evaluation/simulation/odometry_fault.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cornerfix::evaluation {
namespace {

constexpr double kStep = 0.1;    // [m] per scan
constexpr double kPeriod = 0.2;  // [s] per scan

/// What a robot reports that drives straight on for 30 m.
std::vector<Pose2> reported(OdometryFaultKind kind, std::uint64_t seed) {
  OdometryFault fault(kind, seed);
  std::vector<Pose2> poses;
  for (int i = 0; i < 300; ++i) poses.push_back(fault.corrupt(kPeriod * i, {kStep * i, 0.0, 0.0}));
  return poses;
}

std::vector<Pose2> motions(const std::vector<Pose2>& poses) {
  std::vector<Pose2> motions;
  for (std::size_t i = 1; i < poses.size(); ++i)
    motions.push_back(inverse(poses[i - 1]) * poses[i]);
  return motions;
}

TEST(OdometryFault, HasAName) {
  for (const OdometryFaultKind kind : all_odometry_faults())
    EXPECT_EQ(odometry_fault_from_string(to_string(kind)), kind);
  EXPECT_EQ(odometry_fault_from_string("none"), std::nullopt);
  EXPECT_EQ(all_odometry_faults().size(), 5U);
}

TEST(OdometryFault, IsTheSameForTheSameSeedOnly) {
  for (const OdometryFaultKind kind : all_odometry_faults()) {
    EXPECT_EQ(reported(kind, 7), reported(kind, 7)) << to_string(kind);
    if (kind == OdometryFaultKind::kZero) continue;
    EXPECT_NE(reported(kind, 7), reported(kind, 8)) << to_string(kind);
  }
}

TEST(OdometryFault, OfZeroNeverMoves) {
  for (const Pose2& pose : reported(OdometryFaultKind::kZero, 1)) EXPECT_EQ(pose, Pose2{});
}

TEST(OdometryFault, HangsForTenSecondsAndThenReportsTheTruePose) {
  const std::vector<Pose2> poses = reported(OdometryFaultKind::kHang, 3);
  std::size_t still = 0;
  double largest_m = 0.0;
  for (const Pose2& motion : motions(poses)) {
    const double m = motion.translation().norm();
    still += m == 0.0 ? 1 : 0;
    largest_m = std::max(largest_m, m);
  }
  // 60 s: half of them hang, but for the phase.
  EXPECT_GT(still, 90U);
  EXPECT_LT(still, 160U);
  EXPECT_NEAR(largest_m, 50 * kStep, 1.5 * kStep);
}

TEST(OdometryFault, OfTwoPublishersAlternatesBetweenTwoFrames) {
  const std::vector<Pose2> poses = reported(OdometryFaultKind::kTwoPublishers, 4);
  for (std::size_t i = 2; i < poses.size(); ++i) {
    EXPECT_NEAR(distance(poses[i], poses[i - 2]), 2.0 * kStep, 1e-9);
    EXPECT_GT(distance(poses[i], poses[i - 1]), 1.0);
  }
}

TEST(OdometryFault, OfHeadingTurnsTheDirectionOfTravel) {
  for (const Pose2& motion : motions(reported(OdometryFaultKind::kWrongHeading, 5))) {
    EXPECT_NEAR(motion.translation().norm(), kStep, 1e-9);
    EXPECT_GT(std::abs(std::atan2(motion.y, motion.x)), 0.5);
    EXPECT_NEAR(motion.yaw, 0.0, 1e-9);
  }
}

TEST(OdometryFault, JumpsOnceWithinTheFirstMetres) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    int jumps = 0;
    std::size_t last = 0;
    const std::vector<Pose2> steps = motions(reported(OdometryFaultKind::kJump, seed));
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const double m = steps[i].translation().norm();
      if (std::abs(m - kStep) < 1e-9) continue;
      ++jumps;
      last = i;
      EXPECT_GT(m, 4.5);
    }
    EXPECT_LE(jumps, 1);
    EXPECT_LE(static_cast<double>(last) * kStep, 8.1);
  }
}

}  // namespace
}  // namespace cornerfix::evaluation

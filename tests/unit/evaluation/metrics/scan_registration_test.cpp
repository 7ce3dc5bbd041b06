#include "evaluation/metrics/scan_registration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "support/matchers.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix::evaluation {
namespace {

using cornerfix::testing::figure7_room;
using cornerfix::testing::IsPoseNear;
using cornerfix::testing::Lidar;
using cornerfix::testing::SceneBuilder;
using cornerfix::testing::simulate_scan;

const Lidar kLidar{.beams = 360};
const Pose2 kHere{7.5, 5.0, 0.3};

TEST(ScanRegistration, FindsHowTwoScansLieToEachOther) {
  const LaserScan here = simulate_scan(figure7_room(), kLidar, kHere);
  for (const Pose2& T_here_there :
       {Pose2{0.4, -0.3, 0.2}, Pose2{-0.7, 0.5, -0.6}, Pose2{0.0, 0.0, 0.0}}) {
    const LaserScan there = simulate_scan(figure7_room(), kLidar, kHere * T_here_there);
    const auto found = register_scans(here, there, T_here_there * Pose2{0.15, -0.1, 0.1});
    ASSERT_TRUE(found);
    EXPECT_THAT(found->T_a_b, IsPoseNear(T_here_there, 0.002, 0.001));
    EXPECT_GT(found->inlier_share, 0.7);
  }
}

TEST(ScanRegistration, BearsNoise) {
  std::mt19937_64 random(3);
  Lidar noisy = kLidar;
  noisy.noise_m = 0.02;
  const Pose2 T_here_there{0.4, -0.3, 0.2};
  const LaserScan here = simulate_scan(figure7_room(), noisy, kHere, random);
  const LaserScan there = simulate_scan(figure7_room(), noisy, kHere * T_here_there, random);
  const auto found = register_scans(here, there, T_here_there * Pose2{0.1, 0.1, -0.1});
  ASSERT_TRUE(found);
  EXPECT_THAT(found->T_a_b, IsPoseNear(T_here_there, 0.01, 0.005));
}

TEST(ScanRegistration, GivesNothingAlongABareCorridor) {
  const SceneBuilder corridor = SceneBuilder().room({-100, 0}, {100, 2});
  const LaserScan here = simulate_scan(corridor, kLidar, {0, 1, 0});
  const LaserScan there = simulate_scan(corridor, kLidar, {0.5, 1, 0});
  EXPECT_FALSE(register_scans(here, there, {0.5, 0, 0}));
}

TEST(ScanRegistration, GivesNothingInARoundHall) {
  std::vector<Point2> circle;
  for (int i = 0; i < 180; ++i) {
    const double angle = i * std::numbers::pi / 90.0;
    circle.emplace_back(6.0 * std::cos(angle), 6.0 * std::sin(angle));
  }
  const SceneBuilder hall = SceneBuilder().polygon(circle);
  const LaserScan here = simulate_scan(hall, kLidar, {0.2, 0, 0});
  const LaserScan there = simulate_scan(hall, kLidar, {-0.1, 0.2, 0.5});
  EXPECT_FALSE(register_scans(here, there, {-0.3, 0.2, 0.5}));
}

TEST(ScanRegistration, GivesNothingForScansThatShareNoWalls) {
  const LaserScan here = simulate_scan(figure7_room(), kLidar, kHere);
  LaserScan there = simulate_scan(SceneBuilder().room({0, 0}, {1.4, 1.4}), kLidar, {0.7, 0.7, 0});
  EXPECT_FALSE(register_scans(here, there, {}));
  there.ranges.assign(there.ranges.size(), 0.0F);
  EXPECT_FALSE(register_scans(here, there, {}));
  EXPECT_FALSE(register_scans(there, here, {}));
}

}  // namespace
}  // namespace cornerfix::evaluation

#include "core/src/scan/line_intersection_corners.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "support/matchers.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::figure7_room;
using ::testing::IsEmpty;
using testing::IsPointNear;
using testing::Lidar;
using testing::SceneBuilder;
using testing::simulate_scan;
using testing::wedge;

using std::numbers::pi;

std::vector<Corner> corners_of(const LaserScan& scan) {
  return extract_line_intersection_corners(scan, {});
}

std::vector<Corner> corners_of(const SceneBuilder& scene, const Lidar& lidar = {},
                               const Pose2& T_map_laser = {}, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  return corners_of(simulate_scan(scene, lidar, T_map_laser, random));
}

/// The same tip seen from outside.
SceneBuilder spike(double half_angle) { return wedge(half_angle).moved({6.0, 0.0, pi}); }

TEST(LineIntersectionCorners, AreNoneOnStraightWallsWhateverTheNoise) {
  const auto scene = SceneBuilder().wall({4, -12}, {4, 12}).wall({-3, -9}, {-3, 9});
  for (const std::size_t beams : {360U, 1440U}) {
    for (const double noise : {0.0, 0.01, 0.03, 0.07}) {
      for (std::uint64_t seed = 0; seed < 10; ++seed) {
        EXPECT_THAT(corners_of(scene, {.beams = beams, .noise_m = noise}, {0, 0, 0.3}, seed),
                    IsEmpty())
            << "seed " << seed << " noise " << noise;
      }
    }
  }
}

TEST(LineIntersectionCorners, AreNoneAtTheEndsOfWalls) {
  EXPECT_THAT(corners_of(SceneBuilder().wall({2, -0.6}, {2, 1}).wall({-3, 2}, {-1, 3})), IsEmpty());
}

TEST(LineIntersectionCorners, AreNoneWhereOneWallHidesAnother) {
  EXPECT_THAT(corners_of(SceneBuilder().wall({2, -6}, {2, 0}).wall({4, -6}, {4, 6})), IsEmpty());
}

TEST(LineIntersectionCorners, AreNoneOnABumpOfNoise) {
  LaserScan scan = simulate_scan(SceneBuilder().wall({2, -6}, {2, 6}), {}, {});
  for (std::size_t beam = 719; beam < 722; ++beam) scan.ranges[beam] -= 0.14F;
  EXPECT_THAT(corners_of(scan), IsEmpty());
}

TEST(LineIntersectionCorners, AreNoneOnThickRoundPillars) {
  for (const double radius : {0.5, 1.0, 2.0}) {
    std::vector<Point2> circle;
    for (int i = 0; i < 180; ++i) {
      const double angle = 2.0 * pi * i / 180.0;
      circle.push_back(Point2(radius + 2.0, 0.0) +
                       radius * Point2(std::cos(angle), std::sin(angle)));
    }
    EXPECT_THAT(corners_of(SceneBuilder().polygon(circle)), IsEmpty()) << radius << " m";
  }
}

TEST(LineIntersectionCorners, MeasureTheCornerOfARoom) {
  const auto corners = corners_of(wedge(pi / 4.0));
  ASSERT_EQ(corners.size(), 1U);
  EXPECT_THAT(corners[0].position, IsPointNear(Point2(3.0, 0.0), 0.001));
  EXPECT_NEAR(corners[0].turn_angle, pi / 2.0, 0.001);
  EXPECT_NEAR(std::abs(corners[0].bisector), pi, 0.001);  // Back towards the lidar.
  EXPECT_FALSE(corners[0].convex);
}

TEST(LineIntersectionCorners, MeasureACornerThatJutsOut) {
  const auto corners = corners_of(spike(1.1));
  ASSERT_EQ(corners.size(), 1U);
  EXPECT_THAT(corners[0].position, IsPointNear(Point2(3.0, 0.0), 0.001));
  EXPECT_NEAR(corners[0].turn_angle, pi - 2.2, 0.001);
  EXPECT_NEAR(corners[0].bisector, 0.0, 0.001);
  EXPECT_TRUE(corners[0].convex);
}

TEST(LineIntersectionCorners, NeedTheLeastTurn) {
  EXPECT_THAT(corners_of(wedge(1.38)), IsEmpty());  // 22 deg
  EXPECT_EQ(corners_of(wedge(1.30)).size(), 1U);    // 31 deg
}

TEST(LineIntersectionCorners, NeedArmsThatAreNotSeenTooFlat) {
  EXPECT_EQ(corners_of(wedge(0.15)).size(), 1U);    // 8.6 deg between beam and wall
  EXPECT_THAT(corners_of(wedge(0.08)), IsEmpty());  // 4.6 deg
}

TEST(LineIntersectionCorners, AreFoundWhereverTheSeamFalls) {
  const auto room = SceneBuilder().room({-4, -3}, {4, 3});
  for (const double noise : {0.0, 0.03}) {
    for (int seam = 0; seam < 90; ++seam) {
      // Steps that are no multiple of the 0.25 deg between beams.
      const Pose2 T_map_laser{0.5, 0.2, 2.0 * pi * seam / 90.0 + 0.001 * seam};
      EXPECT_EQ(corners_of(room, {.noise_m = noise}, T_map_laser).size(), 4U) << seam;
    }
  }
}

TEST(LineIntersectionCorners, ComeByAscendingBeam) {
  const Pose2 T_map_laser{7.5, 5.0, 0.4};
  const auto corners = corners_of(figure7_room(), {}, T_map_laser);
  ASSERT_GE(corners.size(), 13U);
  EXPECT_TRUE(std::ranges::is_sorted(corners, {}, [](const Corner& corner) {
    return std::atan2(corner.position.y(), corner.position.x());
  }));
}

TEST(LineIntersectionCorners, TurnWithTheLidar) {
  const Pose2 T_map_laser{7.5, 5.0, 0.4};
  const Pose2 T_other_map{-20.0, 35.0, 2.5};
  const auto here = corners_of(figure7_room(), {}, T_map_laser);
  const auto there = corners_of(figure7_room().moved(T_other_map), {}, T_other_map * T_map_laser);
  ASSERT_EQ(here.size(), there.size());
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_THAT(there[i].position, IsPointNear(here[i].position, 1e-3));
    EXPECT_NEAR(wrap_angle(there[i].bisector - here[i].bisector), 0.0, 1e-3);
    EXPECT_EQ(there[i].convex, here[i].convex);
  }
}

TEST(LineIntersectionCorners, AreTheSameWhicheverWayTheLidarTurns) {
  LaserScan scan = simulate_scan(figure7_room(), {}, {7.5, 5.0, 0.4});
  const auto counterclockwise = corners_of(scan);
  scan.angle_min = scan.bearing(scan.ranges.size() - 1);
  scan.angle_increment = -scan.angle_increment;
  std::ranges::reverse(scan.ranges);
  auto clockwise = corners_of(scan);
  std::ranges::reverse(clockwise);
  ASSERT_EQ(clockwise.size(), counterclockwise.size());
  for (std::size_t i = 0; i < clockwise.size(); ++i) {
    EXPECT_THAT(clockwise[i].position, IsPointNear(counterclockwise[i].position, 0.01));
    EXPECT_NEAR(wrap_angle(clockwise[i].bisector - counterclockwise[i].bisector), 0.0, 0.01);
    EXPECT_EQ(clockwise[i].convex, counterclockwise[i].convex);
  }
}

TEST(LineIntersectionCorners, AreFoundInSpiteOfMissingReturns) {
  LaserScan scan = simulate_scan(SceneBuilder().room({-4, -3}, {4, 3}), {}, {0.5, 0.2, 0.1});
  for (std::size_t beam = 0; beam < scan.ranges.size(); beam += 3) {
    scan.ranges[beam] = std::numeric_limits<float>::quiet_NaN();
  }
  EXPECT_EQ(corners_of(scan).size(), 4U);
}

LaserScan full_turn(std::vector<float> ranges) {
  LaserScan scan;
  scan.angle_min = -pi;
  scan.angle_increment = pi / 180.0;
  scan.range_max = 1e38;
  scan.ranges = std::move(ranges);
  return scan;
}

TEST(LineIntersectionCorners, AreNoneInScansWithoutShape) {
  EXPECT_THAT(corners_of(full_turn({})), IsEmpty());
  EXPECT_THAT(corners_of(full_turn({2.0F})), IsEmpty());
  for (const float range : {std::numeric_limits<float>::quiet_NaN(), 0.0F, 1e-30F, 5.0F, 1e30F}) {
    EXPECT_THAT(corners_of(full_turn(std::vector<float>(360, range))), IsEmpty()) << range;
  }
}

TEST(LineIntersectionCorners, AreFiniteWhateverTheRanges) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> exponent(-30.0F, 30.0F);
  std::uniform_real_distribution<float> metres(0.0F, 10.0F);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<float> ranges(360);
    const bool any_magnitude = trial % 2 == 0;
    for (float& range : ranges) {
      range = any_magnitude ? std::pow(10.0F, exponent(random)) : metres(random);
    }
    for (const Corner& corner : corners_of(full_turn(ranges))) {
      EXPECT_TRUE(corner.position.allFinite() && corner.covariance.allFinite()) << trial;
      EXPECT_TRUE(std::isfinite(corner.bisector) && std::isfinite(corner.turn_angle)) << trial;
      EXPECT_TRUE(std::isfinite(corner.gain)) << trial;
    }
  }
}

class RangeNoise : public ::testing::TestWithParam<double> {};

TEST_P(RangeNoise, IsEstimatedFromAScan) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    std::mt19937_64 random(seed);
    const LaserScan scan =
        simulate_scan(figure7_room(), {.noise_m = GetParam()}, {7.5, 5.0, 0.0}, random);
    EXPECT_NEAR(estimate_range_noise(scan), GetParam(), 0.2 * GetParam()) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Sigmas, RangeNoise, ::testing::Values(0.01, 0.03, 0.07));

TEST(RangeNoise, IsNeverBelowThatOfGoodLidars) {
  EXPECT_EQ(estimate_range_noise(simulate_scan(figure7_room(), {}, {7.5, 5.0, 0.0})), 0.006);
  EXPECT_EQ(estimate_range_noise(full_turn({})), 0.006);
}

/// The paper's section 4.2 around its lidar pose: right is within 0.1 m of a corner, suppression
/// within 1 m.
struct Scores {
  double precision = 0.0;
  double recall = 0.0;
  double rms_error_m = 0.0;
  double mean_squared_mahalanobis = 0.0;
};

std::vector<Corner> strongest_within_1_m(std::vector<Corner> corners) {
  std::ranges::sort(corners, std::greater<>(), &Corner::gain);
  std::vector<Corner> kept;
  for (const Corner& corner : corners) {
    if (std::ranges::none_of(kept, [&](const Corner& stronger) {
          return (stronger.position - corner.position).norm() < 1.0;
        })) {
      kept.push_back(corner);
    }
  }
  return kept;
}

Scores scores_in_figure7_room(std::size_t beams, double noise_m) {
  const auto scene = figure7_room();
  double found = 0.0, right = 0.0, visible = 0.0, recalled = 0.0, errors = 0.0, mahalanobis = 0.0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> offset(-1.0, 1.0);
    const Pose2 T_map_laser{7.5 + offset(random), 5.0 + offset(random), pi * offset(random)};
    const auto scene_laser = scene.moved(inverse(T_map_laser));
    const auto corners = strongest_within_1_m(corners_of(
        simulate_scan(scene, {.beams = beams, .noise_m = noise_m}, T_map_laser, random)));
    for (const Corner& corner : corners) {
      const auto reference = scene_laser.corners();
      const Point2 nearest = *std::ranges::min_element(
          reference, {}, [&](const Point2& p) { return (p - corner.position).norm(); });
      const Point2 error = corner.position - nearest;
      found += 1.0;
      if (error.norm() >= 0.1) continue;
      right += 1.0;
      errors += error.squaredNorm();
      mahalanobis += error.dot(corner.covariance.inverse() * error);
    }
    for (const Point2& p : scene_laser.corners_seen(Point2::Zero(), 0.6)) {
      visible += 1.0;
      recalled += std::ranges::any_of(
          corners, [&](const Corner& corner) { return (corner.position - p).norm() < 0.1; });
    }
  }
  return {right / found, recalled / visible, std::sqrt(errors / right), mahalanobis / right};
}

struct Expected {
  std::size_t beams;
  double noise_m;
  Scores least;  ///< Precision and recall at least, error at most.
};

class LineIntersectionScores : public ::testing::TestWithParam<Expected> {};

TEST_P(LineIntersectionScores, InTheRoomOfThePaper) {
  const Expected& expected = GetParam();
  const Scores scores = scores_in_figure7_room(expected.beams, expected.noise_m);
  EXPECT_GE(scores.precision, expected.least.precision);
  EXPECT_GE(scores.recall, expected.least.recall);
  EXPECT_LE(scores.rms_error_m, expected.least.rms_error_m);
  if (expected.noise_m == 0.0) return;
  // Two degrees of freedom: 2 if the covariance is the error's.
  EXPECT_GT(scores.mean_squared_mahalanobis, 1.3);
  EXPECT_LT(scores.mean_squared_mahalanobis, 3.0);
}

INSTANTIATE_TEST_SUITE_P(Beams1440, LineIntersectionScores,
                         ::testing::Values(Expected{1440, 0.0, {1.0, 1.0, 0.001}},
                                           Expected{1440, 0.01, {1.0, 1.0, 0.004}},
                                           Expected{1440, 0.03, {0.995, 0.995, 0.012}},
                                           Expected{1440, 0.07, {0.99, 0.99, 0.033}}));
INSTANTIATE_TEST_SUITE_P(Beams360, LineIntersectionScores,
                         ::testing::Values(Expected{360, 0.0, {1.0, 0.99, 0.002}},
                                           Expected{360, 0.03, {0.99, 0.985, 0.023}},
                                           Expected{360, 0.07, {0.93, 0.93, 0.05}}));

TEST(LineIntersectionParams, AreChecked) {
  EXPECT_FALSE(validate(LineIntersectionParams{}));
  EXPECT_EQ(validate(LineIntersectionParams{.arm_length_m = 0.0})->field, "arm_length_m");
  EXPECT_EQ(validate(LineIntersectionParams{.max_arm_length_m = 0.3})->field, "max_arm_length_m");
  EXPECT_EQ(validate(LineIntersectionParams{.min_arm_points = 2})->field, "min_arm_points");
  EXPECT_EQ(validate(LineIntersectionParams{.min_first_gain = 0.0})->field, "min_first_gain");
  EXPECT_EQ(validate(LineIntersectionParams{.min_gain = std::nan("")})->field, "min_gain");
  EXPECT_EQ(validate(LineIntersectionParams{.min_turn_angle_rad = 4.0})->field,
            "min_turn_angle_rad");
  EXPECT_EQ(validate(LineIntersectionParams{.min_incidence_rad = -0.1})->field,
            "min_incidence_rad");
}

}  // namespace
}  // namespace cornerfix

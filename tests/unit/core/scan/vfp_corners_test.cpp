#include "core/src/scan/vfp_corners.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
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

std::vector<Feature> vfp_corners_of(const LaserScan& scan) {
  return extract_vfp_corners(scan, vfp_params_for(scan.angle_increment));
}

TEST(VfpCorners, FindsNothingOnAStraightWall) {
  const auto scene = SceneBuilder().wall({2, -6}, {2, 6});
  EXPECT_THAT(vfp_corners_of(simulate_scan(scene, {}, {})), IsEmpty());
}

TEST(VfpCorners, FindsNothingAtTheEndsOfWalls) {
  const auto scene = SceneBuilder().wall({2, -0.6}, {2, 1}).wall({-3, 2}, {-1, 3});
  EXPECT_THAT(vfp_corners_of(simulate_scan(scene, {}, {})), IsEmpty());
}

TEST(VfpCorners, FindsNothingOnANoisyWall) {
  const auto scene = SceneBuilder().wall({4, -6}, {4, 6}).wall({-4, -6}, {-4, 6});
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    std::mt19937_64 random(seed);
    EXPECT_THAT(vfp_corners_of(simulate_scan(scene, {.noise_m = 0.02}, {}, random)), IsEmpty())
        << seed;
  }
}

TEST(VfpCorners, FindsNothingOnABumpOfNoise) {
  LaserScan scan = simulate_scan(SceneBuilder().wall({2, -6}, {2, 6}), {}, {});
  for (std::size_t beam = 719; beam < 722; ++beam) scan.ranges[beam] -= 0.14F;
  EXPECT_THAT(vfp_corners_of(scan), IsEmpty());
}

TEST(VfpCorners, MeasuresARightAngle) {
  const auto corners = vfp_corners_of(simulate_scan(wedge(pi / 4.0), {}, {}));
  ASSERT_EQ(corners.size(), 1U);
  EXPECT_THAT(corners[0].position, IsPointNear(Point2(3.0, 0.0), 0.02));
  EXPECT_NEAR(corners[0].turn_angle, pi / 2.0, 0.03);
  EXPECT_EQ(corners[0].weight, corners[0].turn_angle);
  EXPECT_NEAR(std::abs(corners[0].bisector), pi, 0.02);  // Back towards the lidar.
}

TEST(VfpCorners, MeasuresAnObtuseCornerThatPointsAtTheLidar) {
  const auto scene = wedge(1.1).moved({6.0, 0.0, pi});
  const auto corners = vfp_corners_of(simulate_scan(scene, {}, {}));
  ASSERT_EQ(corners.size(), 1U);
  EXPECT_THAT(corners[0].position, IsPointNear(Point2(3.0, 0.0), 0.02));
  EXPECT_NEAR(corners[0].turn_angle, pi - 2.2, 0.03);
  EXPECT_NEAR(corners[0].bisector, 0.0, 0.02);
}

TEST(VfpCorners, NeedsMoreThanTheLeastTurn) {
  EXPECT_THAT(vfp_corners_of(simulate_scan(wedge(1.3), {}, {})), IsEmpty());  // 31 deg
  EXPECT_EQ(vfp_corners_of(simulate_scan(wedge(1.2), {}, {})).size(), 1U);    // 43 deg
}

TEST(VfpCorners, FindsTheSameCornersWhereverTheSeamFalls) {
  const auto scene = figure7_room();
  const Point2 lidar(7.5, 5.0);
  const auto corners = scene.corners_seen(lidar, 0.6);
  ASSERT_EQ(corners.size(), 13U);
  for (const Point2& corner : corners) {
    const Point2 to_corner = corner - lidar;
    // The corner lies straight behind, where the first and the last beam meet.
    const Pose2 T_map_laser{lidar.x(), lidar.y(),
                            wrap_angle(std::atan2(to_corner.y(), to_corner.x()) + pi)};
    const auto found = vfp_corners_of(simulate_scan(scene, {}, T_map_laser));
    EXPECT_TRUE(std::ranges::any_of(found, [&](const Feature& f) {
      return (T_map_laser * f.position - corner).norm() < 0.03;
    })) << corner.transpose();
  }
}

TEST(VfpCorners, FindsACornerAtTheSeamOfAClosedRoom) {
  const auto scene = SceneBuilder().room({-4, -3}, {4, 3});
  const double to_corner = std::atan2(3.0, 4.0);
  const auto found = vfp_corners_of(simulate_scan(scene, {}, {0.0, 0.0, to_corner + pi}));
  EXPECT_EQ(found.size(), 4U);
}

TEST(VfpCorners, TurnWithTheLidar) {
  const auto scene = figure7_room();
  const Pose2 T_map_laser{7.5, 5.0, 0.4};
  const auto here = vfp_corners_of(simulate_scan(scene, {}, T_map_laser));
  const Pose2 T_other_map{-20.0, 35.0, 2.5};
  const auto there =
      vfp_corners_of(simulate_scan(scene.moved(T_other_map), {}, T_other_map * T_map_laser));
  ASSERT_EQ(here.size(), there.size());
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_THAT(there[i].position, IsPointNear(here[i].position, 1e-3));
    EXPECT_NEAR(there[i].turn_angle, here[i].turn_angle, 1e-3);
  }
}

TEST(VfpCorners, AreTheSameWhicheverWayTheLidarTurns) {
  LaserScan scan = simulate_scan(figure7_room(), {}, {7.5, 5.0, 0.4});
  const auto counterclockwise = vfp_corners_of(scan);
  scan.angle_min = scan.bearing(scan.ranges.size() - 1);
  scan.angle_increment = -scan.angle_increment;
  std::ranges::reverse(scan.ranges);
  EXPECT_EQ(vfp_corners_of(scan).size(), counterclockwise.size());
}

TEST(VfpCorners, KeepTheLargestTurnOfEachNeighborhood) {
  const LaserScan scan = simulate_scan(figure7_room(), {}, {7.5, 5.0, 0.0});
  VfpParams params = vfp_params_for(scan.angle_increment);
  params.suppression_radius_m = 1e-6;
  const auto all = extract_vfp_corners(scan, params);
  const auto kept = vfp_corners_of(scan);
  ASSERT_GT(all.size(), kept.size());
  for (const Feature& corner : kept) {
    for (const Feature& other : all) {
      if ((other.position - corner.position).norm() >= 0.5) continue;
      EXPECT_LE(other.turn_angle, corner.turn_angle);
    }
  }
}

TEST(VfpCorners, AreNoneInScansWithoutShape) {
  LaserScan scan;
  scan.angle_min = -pi;
  scan.angle_increment = pi / 180.0;
  scan.range_max = 30.0;
  EXPECT_THAT(vfp_corners_of(scan), IsEmpty());
  scan.ranges = {2.0F};
  EXPECT_THAT(vfp_corners_of(scan), IsEmpty());
  scan.ranges.assign(360, std::numeric_limits<float>::quiet_NaN());
  EXPECT_THAT(vfp_corners_of(scan), IsEmpty());
  scan.ranges.assign(360, 5.0F);
  EXPECT_THAT(vfp_corners_of(scan), IsEmpty());
  scan.ranges.assign(360, 0.0F);
  EXPECT_THAT(vfp_corners_of(scan), IsEmpty());
}

struct Rates {
  double precision;
  double recall;
};

/// The paper's section 4.2 around its lidar pose: right is within 0.1 m of a corner, suppression
/// within 1 m.
Rates rates_in_figure7_room(std::size_t beams, double noise_m) {
  const auto scene = figure7_room();
  const auto corners = scene.corners();
  std::size_t found = 0;
  std::size_t right = 0;
  std::size_t visible = 0;
  std::size_t recalled = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> offset(-1.0, 1.0);
    const Pose2 T_map_laser{7.5 + offset(random), 5.0 + offset(random), pi * offset(random)};
    const Lidar lidar{.beams = beams, .noise_m = noise_m};
    const LaserScan scan = simulate_scan(scene, lidar, T_map_laser, random);
    VfpParams params = vfp_params_for(scan.angle_increment);
    params.suppression_radius_m = 1.0;
    std::vector<Point2> detections;
    for (const Feature& feature : extract_vfp_corners(scan, params)) {
      detections.push_back(T_map_laser * feature.position);
    }
    const auto is_near_one_of = [](const std::vector<Point2>& points) {
      return [&points](const Point2& p) {
        return std::ranges::any_of(points, [&](const Point2& q) { return (p - q).norm() < 0.1; });
      };
    };
    const auto clear = scene.corners_seen(T_map_laser.translation(), 0.6);
    found += detections.size();
    visible += clear.size();
    right += static_cast<std::size_t>(std::ranges::count_if(detections, is_near_one_of(corners)));
    recalled += static_cast<std::size_t>(std::ranges::count_if(clear, is_near_one_of(detections)));
  }
  return {static_cast<double>(right) / static_cast<double>(found),
          static_cast<double>(recalled) / static_cast<double>(visible)};
}

TEST(VfpCorners, FindsAllCornersAndNothingElseWithoutNoise) {
  const Rates rates = rates_in_figure7_room(1440, 0.0);
  EXPECT_GE(rates.precision, 0.995);
  EXPECT_GE(rates.recall, 0.995);
}

TEST(VfpCorners, FindsNearlyAllCornersAtThreeCentimetresOfNoise) {
  const Rates rates = rates_in_figure7_room(1440, 0.03);
  EXPECT_GE(rates.precision, 0.96);
  EXPECT_GE(rates.recall, 0.97);
}

TEST(VfpCorners, FindsNearlyAllCornersWithABeamADegree) {
  const Rates without_noise = rates_in_figure7_room(360, 0.0);
  EXPECT_GE(without_noise.precision, 0.94);
  EXPECT_GE(without_noise.recall, 0.94);
  const Rates with_noise = rates_in_figure7_room(360, 0.03);
  EXPECT_GE(with_noise.precision, 0.88);
  EXPECT_GE(with_noise.recall, 0.88);
}

class VfpBeams : public ::testing::TestWithParam<std::size_t> {};

TEST_P(VfpBeams, FindsTheCornersOfARoom) {
  const auto scene = SceneBuilder().room({0, 0}, {7, 5});
  const Pose2 T_map_laser{3.0, 2.2, 0.7};
  const auto found = vfp_corners_of(simulate_scan(scene, {.beams = GetParam()}, T_map_laser));
  EXPECT_EQ(found.size(), 4U);
  for (const Feature& corner : found) {
    const Point2 p = T_map_laser * corner.position;
    const double spacing = 2.0 * pi / static_cast<double>(GetParam()) * corner.position.norm();
    EXPECT_THAT(p, IsPointNear(Point2(p.x() < 3.5 ? 0.0 : 7.0, p.y() < 2.5 ? 0.0 : 5.0), spacing));
    EXPECT_NEAR(corner.turn_angle, pi / 2.0, 0.35);
  }
}

INSTANTIATE_TEST_SUITE_P(From180To2000, VfpBeams,
                         ::testing::Values(180, 240, 360, 541, 720, 1081, 1440, 2000));

TEST(SmoothnessScores, AreTheSumsOfTheirDefinition) {
  std::mt19937_64 random(3);
  const auto segments = cut_into_segments(
      simulate_scan(figure7_room(), {.noise_m = 0.05}, {7.5, 5.0, 0.0}, random), {});
  ASSERT_FALSE(segments.empty());
  const auto& points = segments[0].points;
  const int window = 7;
  const auto scores = smoothness_scores(points, window);
  for (int k = 0; k < static_cast<int>(points.size()); ++k) {
    const ScanPoint& h_k = points[static_cast<std::size_t>(k)];
    Point2 sum = Point2::Zero();
    int others = 0;
    for (int j = k - window; j <= k + window; ++j) {
      if (j == k || j < 0 || j >= static_cast<int>(points.size())) continue;
      sum += h_k.position - points[static_cast<std::size_t>(j)].position;
      ++others;
    }
    EXPECT_NEAR(scores[static_cast<std::size_t>(k)], sum.norm() / (others * h_k.range), 1e-9) << k;
  }
}

TEST(SmoothnessScores, OfASinglePointIsZero) {
  const std::vector<ScanPoint> lone{{.position = {1.0, 0.0}, .range = 1.0}};
  EXPECT_EQ(smoothness_scores(lone, 5), std::vector<double>{0.0});
}

TEST(VfpParams, RunFromTheFineToTheCoarseSet) {
  const VfpParams fine = vfp_params_for(0.1 * pi / 180.0);
  EXPECT_EQ(fine.window, 10);
  EXPECT_DOUBLE_EQ(fine.min_score, 0.001);
  const VfpParams half = vfp_params_for(0.5 * pi / 180.0);
  EXPECT_EQ(half.window, 7);
  EXPECT_NEAR(half.min_score, 0.002, 1e-9);
  const VfpParams coarse = vfp_params_for(-2.0 * pi / 180.0);
  EXPECT_EQ(coarse.window, 4);
  EXPECT_DOUBLE_EQ(coarse.min_score, 0.004);
  EXPECT_DOUBLE_EQ(coarse.inlier_distance_m, 0.12);
}

TEST(VfpParams, NameTheBrokenLimit) {
  EXPECT_FALSE(validate(VfpParams{}));
  EXPECT_EQ(validate(VfpParams{.segments = {.gap_m = -1.0}})->field, "segments.gap_m");
  EXPECT_EQ(validate(VfpParams{.window = 0})->field, "window");
  EXPECT_EQ(validate(VfpParams{.min_score = -1.0})->field, "min_score");
  EXPECT_EQ(validate(VfpParams{.neighbor_distance_m = 0.0})->field, "neighbor_distance_m");
  EXPECT_EQ(validate(VfpParams{.inlier_distance_m = 0.0})->field, "inlier_distance_m");
  EXPECT_EQ(validate(VfpParams{.min_turn_angle_rad = 4.0})->field, "min_turn_angle_rad");
  EXPECT_EQ(validate(VfpParams{.suppression_radius_m = 0.0})->field, "suppression_radius_m");
}

}  // namespace
}  // namespace cornerfix

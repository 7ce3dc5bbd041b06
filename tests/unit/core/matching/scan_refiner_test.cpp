#include "core/src/matching/scan_refiner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <numbers>
#include <random>

#include "support/drawn_grid.hpp"
#include "support/matchers.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;
using testing::SceneBuilder;

using std::numbers::pi;
constexpr double kFieldResolution = 0.05;

DistanceField field_of(const SceneBuilder& scene, const Pose2& T_map_grid, const Point2& size_m) {
  OccupancyGrid grid = testing::unknown_grid(T_map_grid, size_m, kFieldResolution);
  testing::draw_walls(grid, scene);
  return DistanceField(grid);
}

/// Walls of the figure's room run through the middle of cells.
DistanceField room_field() {
  return field_of(testing::figure7_room(), {-1.025, -1.025, 0.0}, {12.0, 12.0});
}

std::vector<Point2> points_seen(const SceneBuilder& scene, const Pose2& T_map_laser,
                                double range_max_m, std::mt19937_64& random) {
  const testing::Lidar lidar{.beams = 360, .range_max_m = range_max_m, .noise_m = 0.01};
  return returns_as_points(testing::simulate_scan(scene, lidar, T_map_laser, random));
}

Pose2 perturbed(const Pose2& pose, double metres, double radians, std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  return {pose.x + metres * share(random), pose.y + metres * share(random),
          wrap_angle(pose.yaw + radians * share(random))};
}

/// 60 m long along x, 2 m wide; a lidar of 10 m at (30, 1) does not see its ends.
SceneBuilder long_corridor() { return SceneBuilder().wall({0, 0}, {60, 0}).wall({0, 2}, {60, 2}); }

DistanceField corridor_field() {
  return field_of(long_corridor(), {-1.025, -1.025, 0.0}, {62.0, 4.0});
}

TEST(ScanRefiner, FindsAPerturbedPoseAgain) {
  const SceneBuilder room = testing::figure7_room();
  const DistanceField field = room_field();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    const Pose2 truth = perturbed({6.0, 5.0, 0.0}, 1.5, pi, random);
    const std::vector<Point2> points = points_seen(room, truth, 30.0, random);
    const Pose2 start = perturbed(truth, 0.1, 0.04, random);
    EXPECT_THAT(refine_pose(field, points, start, {}).T_frame_base_link,
                IsPoseNear(truth, 0.02, 0.005))
        << "seed " << seed;
  }
}

TEST(ScanRefiner, AWideKernelFirstReachesFarther) {
  const SceneBuilder room = testing::figure7_room();
  const DistanceField field = room_field();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    const Pose2 truth = perturbed({6.0, 5.0, 0.0}, 1.5, pi, random);
    const std::vector<Point2> points = points_seen(room, truth, 30.0, random);
    const Pose2 start = perturbed(truth, 0.3, 0.15, random);
    const Pose2 coarse = refine_pose(field, points, start, {.kernel_m = 0.4}).T_frame_base_link;
    EXPECT_THAT(refine_pose(field, points, coarse, {}).T_frame_base_link,
                IsPoseNear(truth, 0.02, 0.005))
        << "seed " << seed;
  }
}

TEST(ScanRefiner, StrangersInTheScanDoNotPull) {
  const SceneBuilder room = testing::figure7_room();
  std::mt19937_64 random(7);
  const Pose2 truth{6.0, 5.0, 1.0};
  const SceneBuilder with_box = testing::figure7_room().box({8.2, 4.0}, {0.8, 0.8}, 0.2);
  const std::vector<Point2> points = points_seen(with_box, truth, 30.0, random);
  const RefinedPose refined = refine_pose(room_field(), points, {6.06, 4.95, 1.03}, {});
  EXPECT_THAT(refined.T_frame_base_link, IsPoseNear(truth, 0.02, 0.005));
  EXPECT_LT(refined.inlier_share, 0.95);
}

TEST(ScanRefiner, LeavesAPoseAtTheAngleSeamThere) {
  const SceneBuilder room = testing::figure7_room();
  std::mt19937_64 random(8);
  const Pose2 truth{6.0, 5.0, pi};
  const std::vector<Point2> points = points_seen(room, truth, 30.0, random);
  for (const double start_yaw : {pi - 0.03, -pi + 0.03}) {
    const PosePrior prior = isotropic_prior({6.0, 5.0, -start_yaw}, 0.05, 0.03);
    EXPECT_THAT(
        refine_pose(room_field(), points, {6.0, 5.0, start_yaw}, {}, prior).T_frame_base_link,
        IsPoseNear(truth, 0.02, 0.01));
  }
}

TEST(ScanRefiner, ABareCorridorLeavesItsAxisWhereItWas) {
  std::mt19937_64 random(1);
  const Pose2 truth{30.0, 1.0, 0.3};
  const std::vector<Point2> points = points_seen(long_corridor(), truth, 10.0, random);
  const Pose2 refined =
      refine_pose(corridor_field(), points, {30.4, 1.08, 0.27}, {}).T_frame_base_link;
  EXPECT_NEAR(refined.x, 30.4, 0.03);
  EXPECT_NEAR(refined.y, 1.0, 0.02);
  EXPECT_NEAR(refined.yaw, 0.3, 0.005);
}

TEST(ScanRefiner, InformationShowsTheBlindDirection) {
  std::mt19937_64 random(2);
  for (const double turn : {0.0, 0.5, pi / 2.0, 2.5}) {
    const Pose2 T{0.0, 0.0, turn};
    const SceneBuilder scene = long_corridor().moved(T);
    const Pose2 T_map_grid = T * Pose2{18.0, -11.025, 0.0};  // walls run along its cells
    const DistanceField field = field_of(scene, T_map_grid, {24.0, 24.0});
    const Pose2 truth = T * Pose2{30.0, 1.0, 0.3};
    const std::vector<Point2> points = points_seen(scene, truth, 8.0, random);
    const Eigen::Matrix2d information =
        observed_information(field, points, truth, {}).topLeftCorner<2, 2>();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(information);
    const Point2 axis(std::cos(turn), std::sin(turn));
    EXPECT_LT(solver.eigenvalues()(0), 0.1 * solver.eigenvalues()(1)) << "turned by " << turn;
    EXPECT_GT(std::abs(solver.eigenvectors().col(0).dot(axis)), 0.99) << "turned by " << turn;
  }
}

/// The steps of a slanted wall in the grid turn its normals, which looks like information along it.
TEST(ScanRefiner, ASlantedCorridorIsHardlyKnownAlongItsAxis) {
  std::mt19937_64 random(2);
  const Pose2 T{0.0, 0.0, 0.5};
  const SceneBuilder scene = long_corridor().moved(T);
  const Pose2 truth = T * Pose2{30.0, 1.0, 0.3};
  const DistanceField field = field_of(scene, {truth.x - 12.0, truth.y - 12.0, 0.0}, {24.0, 24.0});
  const std::vector<Point2> points = points_seen(scene, truth, 8.0, random);
  const Point2 axis(std::cos(T.yaw), std::sin(T.yaw));
  const Point2 normal(-axis.y(), axis.x());
  const auto known = [&](const Point2& direction, double normal_error_rad) {
    const Eigen::Matrix2d information =
        observed_information(field, points, truth, {.normal_error_rad = normal_error_rad})
            .topLeftCorner<2, 2>();
    return direction.dot(information * direction);
  };
  EXPECT_LT(known(axis, 0.0), 0.5 * known(normal, 0.0));
  EXPECT_LT(known(axis, 0.3), 0.1 * known(axis, 0.0));
  EXPECT_GT(known(normal, 0.3), 0.8 * known(normal, 0.0));
}

TEST(ScanRefiner, APriorPullsAlongTheBlindAxisAlone) {
  std::mt19937_64 random(3);
  const Pose2 truth{30.0, 1.0, 0.0};
  const std::vector<Point2> points = points_seen(long_corridor(), truth, 10.0, random);
  const PosePrior prior = isotropic_prior({30.5, 1.1, 0.0}, 0.2, 0.1);
  const Pose2 refined = refine_pose(corridor_field(), points, truth, {}, prior).T_frame_base_link;
  EXPECT_NEAR(refined.x, 30.5, 0.05);
  EXPECT_NEAR(refined.y, 1.0, 0.02);
}

TEST(ScanRefiner, APriorHardlyPullsWhereTheWallsTell) {
  std::mt19937_64 random(4);
  const Pose2 truth{6.0, 5.0, 1.0};
  const std::vector<Point2> points = points_seen(testing::figure7_room(), truth, 30.0, random);
  const PosePrior prior = isotropic_prior({6.1, 4.9, 1.05}, 0.1, 0.05);
  EXPECT_THAT(refine_pose(room_field(), points, truth, {}, prior).T_frame_base_link,
              IsPoseNear(truth, 0.02, 0.005));
}

TEST(ScanRefiner, AFirmPriorHolds) {
  std::mt19937_64 random(5);
  const std::vector<Point2> points =
      points_seen(testing::figure7_room(), {6.0, 5.0, 1.0}, 30.0, random);
  const Pose2 held{6.08, 4.95, 1.03};
  EXPECT_THAT(refine_pose(room_field(), points, held, {}, isotropic_prior(held, 1e-5, 1e-5))
                  .T_frame_base_link,
              IsPoseNear(held, 0.002, 0.002));
}

TEST(ScanRefiner, PointsOffTheMapSayNothing) {
  EXPECT_TRUE(
      observed_information(room_field(), std::vector<Point2>{{500.0, 0.0}}, {}, {}).isZero());
}

TEST(ScanRefiner, WithoutPointsStaysWhereItIs) {
  const Pose2 start{3.0, 4.0, 0.5};
  const RefinedPose refined = refine_pose(room_field(), {}, start, {});
  EXPECT_EQ(refined.T_frame_base_link, start);
  EXPECT_TRUE(observed_information(room_field(), {}, start, {}).isZero());
  EXPECT_EQ(refined.inlier_share, 0.0);
}

TEST(ScanRefiner, PointsInTheOpenDoNotMoveIt) {
  const Pose2 start{6.0, 5.0, 0.5};
  const std::vector<Point2> in_the_open{{0.1, 0.0}, {0.0, 0.2}, {-0.1, 0.1}, {900.0, 900.0}};
  const RefinedPose refined = refine_pose(room_field(), in_the_open, start, {});
  EXPECT_THAT(refined.T_frame_base_link, IsPoseNear(start, 1e-9, 1e-9));
  EXPECT_EQ(refined.inlier_share, 0.0);
}

TEST(ScanRefiner, CountsTheShareOfPointsOnWalls) {
  std::mt19937_64 random(6);
  const Pose2 truth{6.0, 5.0, 1.0};
  std::vector<Point2> points = points_seen(testing::figure7_room(), truth, 30.0, random);
  EXPECT_GT(refine_pose(room_field(), points, truth, {}).inlier_share, 0.99);
  points.resize(2 * points.size(), Point2(0.2, 0.1));
  EXPECT_NEAR(refine_pose(room_field(), points, truth, {}).inlier_share, 0.5, 0.01);
}

TEST(ScanRefiner, AlignsAsItRefinesForAnyNumberOfPoints) {
  std::mt19937_64 random(8);
  const DistanceField field = room_field();
  const Pose2 truth{6.0, 5.0, 1.0};
  const std::vector<Point2> points = points_seen(testing::figure7_room(), truth, 30.0, random);
  const Pose2 start = perturbed(truth, 0.1, 0.04, random);
  for (const std::size_t count : {0, 1, 31, 32, 33, 100}) {
    const std::span<const Point2> some = std::span(points).first(count);
    EXPECT_EQ(aligned_pose(field, some, start, {}),
              refine_pose(field, some, start, {}).T_frame_base_link)
        << count << " points";
  }
}

TEST(ScanRefiner, APointOutsideTheFieldChangesNothing) {
  std::mt19937_64 random(9);
  const Pose2 truth{6.0, 5.0, 1.0};
  std::vector<Point2> points = points_seen(testing::figure7_room(), truth, 30.0, random);
  const Pose2 start = perturbed(truth, 0.1, 0.04, random);
  const Pose2 without = aligned_pose(room_field(), points, start, {});
  points.insert(points.begin() + 5, Point2{500.0, 0.0});
  EXPECT_THAT(aligned_pose(room_field(), points, start, {}), IsPoseNear(without, 1e-12, 1e-12));
}

TEST(ScanRefiner, AFieldWithYawGivesTheSamePose) {
  const SceneBuilder room = testing::figure7_room();
  const DistanceField straight = room_field();
  for (const double yaw : {3.14, -1.5, 0.4}) {
    std::mt19937_64 random(9);
    const Pose2 truth{6.5, 4.5, 0.8};
    const std::vector<Point2> points = points_seen(room, truth, 30.0, random);
    const Pose2 start = perturbed(truth, 0.1, 0.04, random);
    const PosePrior prior = isotropic_prior(start, 0.5, 0.3);
    const Pose2 T_map_grid = Pose2{5.0, 5.0, yaw} * Pose2{-9.0, -9.0, 0.0};
    const DistanceField turned = field_of(room, T_map_grid, {18.0, 18.0});
    const Pose2 pose = refine_pose(turned, points, start, {}, prior).T_frame_base_link;
    const Pose2 expected = refine_pose(straight, points, start, {}, prior).T_frame_base_link;
    EXPECT_THAT(pose, IsPoseNear(expected, 0.03, 0.01)) << "yaw " << yaw;
    const Eigen::Matrix3d information = observed_information(straight, points, expected, {});
    EXPECT_LT((observed_information(turned, points, pose, {}) - information).norm(),
              0.25 * information.norm())
        << "yaw " << yaw;
  }
}

TEST(ScanRefiner, MovingTheMapMovesTheAnswer) {
  const SceneBuilder room = testing::figure7_room();
  std::mt19937_64 random(10);
  const Pose2 truth{6.0, 5.0, 1.0};
  const std::vector<Point2> points = points_seen(room, truth, 30.0, random);
  const Pose2 start = perturbed(truth, 0.1, 0.04, random);
  const Pose2 T{-40.0, 25.0, 2.0};
  const DistanceField field = field_of(room, {-1.025, -1.025, 0.0}, {12.0, 12.0});
  const DistanceField moved = field_of(room.moved(T), T * Pose2{-1.025, -1.025, 0.0}, {12.0, 12.0});
  EXPECT_THAT(refine_pose(moved, points, T * start, {}).T_frame_base_link,
              IsPoseNear(T * refine_pose(field, points, start, {}).T_frame_base_link, 1e-3, 1e-3));
}

}  // namespace
}  // namespace cornerfix

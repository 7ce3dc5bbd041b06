#include "core/src/slam/loop_closer.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "support/matchers.hpp"
#include "support/posed_drive.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;

/// What an earlier run saw, at its true poses.
const SubmapMosaic& office_mosaic() {
  static const SubmapMosaic mosaic = [] {
    const auto& drive = testing::office_drive();
    const DriveSubmap submaps[] = {make_drive_submap(drive, {0, drive.size()})};
    const Pose2 poses[] = {submaps[0].T_drive_submap};
    return SubmapMosaic(submaps, poses);
  }();
  return mosaic;
}

/// The submap of a later run into the first room.
DriveSubmap later_submap(const testing::SceneBuilder& scene) {
  const Point2 points[] = {{1.2, 1.1}, {2.1, 1.3}, {1.9, 4.6}, {2.4, 6.0}};
  const auto drive = testing::posed_scans(scene, testing::route(points, 0.3), 12);
  return make_drive_submap(drive, {0, drive.size()});
}

constexpr DriftBound kDrift{.position_m = 1.5, .yaw_rad = 0.3};

TEST(LoopCloser, FindsASubmapThatDriftedALittle) {
  const DriveSubmap submap = later_submap(testing::offices());
  const Pose2 truth = submap.T_drive_submap;
  const auto found = find_place(submap, office_mosaic(), Pose2{0.6, -0.5, 0.1} * truth, kDrift);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->is_near);
  EXPECT_THAT(found->T_map_submap, IsPoseNear(truth, 0.05, 0.02));
}

TEST(LoopCloser, SaysWhenThePoseIsFartherThanTheDrift) {
  const DriveSubmap submap = later_submap(testing::offices());
  const Pose2 truth = submap.T_drive_submap;
  const auto found = find_place(submap, office_mosaic(), Pose2{8.0, 3.0, 0.0} * truth, kDrift);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->is_near);
  EXPECT_THAT(found->T_map_submap, IsPoseNear(truth, 0.05, 0.02));
}

TEST(LoopCloser, FindsNothingOnNewGround) {
  const auto elsewhere =
      testing::SceneBuilder().room({0.3, 0.4}, {3.1, 7.2}).box({2.8, 2.2}, {0.5, 0.9}, 0.3);
  const DriveSubmap submap = later_submap(elsewhere);
  EXPECT_FALSE(find_place(submap, office_mosaic(), submap.T_drive_submap, kDrift));
}

TEST(LoopCloser, RelatesAScanToASubmap) {
  const DriveSubmap submap = later_submap(testing::offices());
  const Pose2 truth = inverse(submap.T_drive_submap) * Pose2{2.0, 3.5, 1.2};
  const auto points = returns_as_points(
      testing::simulate_scan(testing::offices(), {.beams = 180}, submap.T_drive_submap * truth));
  const auto relation = relate(points, submap, truth * Pose2{0.15, -0.1, 0.05});
  ASSERT_TRUE(relation);
  EXPECT_THAT(relation->T_from_to, IsPoseNear(truth, 0.04, 0.01));
  EXPECT_TRUE(relation->may_be_wrong);
  EXPECT_GT(relation->information.determinant(), 0.0);
}

TEST(LoopCloser, RelatesNothingThatDoesNotFit) {
  const DriveSubmap submap = later_submap(testing::offices());
  const auto other = testing::SceneBuilder().room({-1.1, -0.9}, {1.3, 0.8});
  const auto points = returns_as_points(testing::simulate_scan(other, {.beams = 180}, {}));
  EXPECT_FALSE(relate(points, submap, {}));
}

}  // namespace
}  // namespace cornerfix

#include "core/src/local_map/scan_motion.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "support/matchers.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::IsPointNear;
using testing::IsPoseNear;

TEST(ScanMotion, PutsPointsIntoBaseLink) {
  LaserScan scan{.angle_min = 0.0,
                 .angle_increment = 0.1,
                 .range_min = 0.05,
                 .range_max = 30.0,
                 .ranges = {2.0F}};
  const auto points = points_to_match(scan, {0.3, 0.1, std::numbers::pi / 2.0});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_THAT(points[0], IsPointNear(Point2(0.3, 2.1), 1e-9));
}

TEST(ScanMotion, ThinsAScanOfManyBeams) {
  const auto room = testing::SceneBuilder().room({-3, -3}, {3, 3});
  EXPECT_EQ(points_to_match(testing::simulate_scan(room, {.beams = 1440}, {}), {}).size(), 360U);
}

TEST(ScanMotion, OdometryIsLessCertainTheMoreItMoved) {
  const Eigen::Vector3d still = odometry_noise({});
  const Eigen::Vector3d moved = odometry_noise({1.0, 0.0, 0.5});
  EXPECT_TRUE((still.array() > 0.0).all());
  EXPECT_TRUE((moved.array() > still.array()).all());
}

TEST(ScanMotion, DriftDoesNotDependOnTheScanRate) {
  const Eigen::Vector3d at_once = odometry_drift({1.0, 0.0, 0.5});
  const Eigen::Vector3d in_steps = 10.0 * odometry_drift({0.1, 0.0, 0.05});
  EXPECT_TRUE(in_steps.isApprox(at_once));
  EXPECT_TRUE((at_once.array() > 0.0).all());
  EXPECT_EQ(odometry_drift({}), Eigen::Vector3d::Zero());
}

TEST(ScanMotion, UnchangedOdometryIsLessCertainThanASmallMotion) {
  EXPECT_LT(standing_prior({}).information.trace(), odometry_prior({}, {}).information.trace());
}

TEST(ScanMotion, PriorsPredictTheNextPose) {
  const Pose2 here{3.0, 2.0, 0.7};
  const Pose2 motion{0.4, 0.0, 0.1};
  EXPECT_THAT(odometry_prior(here, motion).T_frame_base_link, IsPoseNear(here * motion, 0, 0));
  EXPECT_THAT(constant_velocity_prior(here, motion).T_frame_base_link,
              IsPoseNear(here * motion, 0, 0));
}

TEST(ScanMotion, TheNoiseScaleMakesThePriorWeaker) {
  const Pose2 motion{0.4, 0.0, 0.1};
  const PosePrior usual = odometry_prior({}, motion);
  const PosePrior weak = odometry_prior({}, motion, Eigen::Vector3d::Constant(3.0));
  EXPECT_TRUE(weak.information.isApprox(usual.information / 9.0));
}

TEST(ScanMotion, OdometrySaysMoreThanConstantVelocity) {
  const Pose2 motion{0.4, 0.0, 0.1};
  EXPECT_GT(odometry_prior({}, motion).information.trace(),
            constant_velocity_prior({}, motion).information.trace());
}

}  // namespace
}  // namespace cornerfix

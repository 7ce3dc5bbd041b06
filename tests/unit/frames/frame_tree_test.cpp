#include "frames/frame_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace cornerfix {
namespace {

StampedTransform moved(double stamp, std::string parent, std::string child, double x,
                       double yaw = 0.0) {
  StampedTransform transform{stamp, std::move(parent), std::move(child),
                             Eigen::Isometry3d::Identity()};
  transform.T_parent_child.translation().x() = x;
  transform.T_parent_child.linear() =
      Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return transform;
}

constexpr auto kStatic = FrameTree::Origin::kStatic;
constexpr auto kTf = FrameTree::Origin::kTf;

TEST(FrameTree, InterpolatesBetweenStampsTheShortWayRound) {
  FrameTree frames;
  frames.add(moved(1.0, "odom", "laser", 2.0, 3.1), kTf);
  frames.add(moved(2.0, "odom", "laser", 3.0, -3.1), kTf);
  const auto found = frames.find("odom", "laser", 1.5);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->is_final);
  EXPECT_NEAR(found->transform.translation().x(), 2.5, 1e-12);
  EXPECT_NEAR(found->transform(0, 0), std::cos(std::numbers::pi), 1e-9);
}

TEST(FrameTree, HoldsTheLastTransformForAMomentOnly) {
  FrameTree frames;
  frames.add(moved(1.0, "odom", "laser", 2.0), kTf);
  const auto soon = frames.find("odom", "laser", 1.05);
  ASSERT_TRUE(soon);
  EXPECT_FALSE(soon->is_final);
  EXPECT_FALSE(frames.find("odom", "laser", 1.5));
  EXPECT_FALSE(frames.find("odom", "laser", 0.9));
}

TEST(FrameTree, DoesNotBridgeALongGap) {
  FrameTree frames;
  frames.add(moved(1.0, "odom", "laser", 2.0), kTf);
  frames.add(moved(3.0, "odom", "laser", 4.0), kTf);
  EXPECT_FALSE(frames.find("odom", "laser", 2.0));
  EXPECT_TRUE(frames.find("odom", "laser", 3.0));
}

TEST(FrameTree, KeepsTheTransformsBeforeAClockWasSetAhead) {
  FrameTree frames;
  frames.add(moved(1.0, "odom", "laser", 2.0), kTf);
  frames.add(moved(2.0, "odom", "laser", 3.0), kTf);
  frames.add(moved(5000.0, "odom", "laser", 4.0), kTf);
  EXPECT_TRUE(frames.find("odom", "laser", 1.5));
  EXPECT_TRUE(frames.find("odom", "laser", 5000.0));
  EXPECT_FALSE(frames.find("odom", "laser", 2500.0));
}

TEST(FrameTree, BridgesALongGapInWhichAFrameRested) {
  FrameTree frames;
  frames.add(moved(1.0, "odom", "laser", 2.0), kTf);
  frames.add(moved(4.0, "odom", "laser", 2.0), kTf);
  EXPECT_TRUE(frames.find("odom", "laser", 2.0));
}

TEST(FrameTree, FindsFramesWithPrefixAndSuffix) {
  FrameTree frames;
  frames.add(moved(1.0, "robot/odom_combined", "robot/laser", 2.0), kStatic);
  EXPECT_TRUE(frames.find("odom", "robot/laser", 7.0));
  EXPECT_FALSE(frames.find("map", "robot/laser", 7.0));
}

TEST(FrameTree, ConnectsFramesByTheFirstOneAboveBoth) {
  FrameTree frames;
  frames.add(moved(1.0, "base_footprint", "base_link", 0.1), kStatic);
  frames.add(moved(1.0, "base_link", "laser", 0.3), kStatic);
  frames.add(moved(1.0, "base_link", "arm", -0.2), kStatic);
  EXPECT_NEAR(frames.between("arm", "laser", 1.0)->transform.translation().x(), 0.5, 1e-12);
  EXPECT_NEAR(frames.between("laser", "base_footprint", 1.0)->transform.translation().x(), -0.4,
              1e-12);
  EXPECT_FALSE(frames.between("camera", "laser", 1.0));
}

TEST(FrameTree, FindsAFrameThatMovesBelowTheBase) {
  FrameTree frames;
  frames.add(moved(1.0, "base_link", "laser", 0.3), kStatic);
  frames.add(moved(1.0, "base_link", "odom", -2.0), kTf);
  EXPECT_NEAR(frames.find("odom", "laser", 1.0)->transform.translation().x(), 2.3, 1e-12);
  EXPECT_FALSE(frames.find("odom", "laser", 7.0));
  EXPECT_FALSE(frames.find("map", "laser", 1.0));
}

TEST(FrameTree, PrefersAFrameAboveToOneBelow) {
  FrameTree frames;
  frames.add(moved(1.0, "base_link", "laser", 0.3), kStatic);
  frames.add(moved(1.0, "base_link", "odom_lidar", -2.0), kTf);
  frames.add(moved(1.0, "odom", "base_link", 5.0), kTf);
  EXPECT_NEAR(frames.find("odom", "laser", 1.0)->transform.translation().x(), 5.3, 1e-12);
}

TEST(FrameTree, TakesNoFixedPartBelowTheBaseNorAnotherTree) {
  FrameTree frames;
  frames.add(moved(1.0, "base_link", "laser", 0.3), kStatic);
  frames.add(moved(1.0, "base_link", "odometer_link", -0.2), kStatic);
  frames.add(moved(1.0, "robot2/base_link", "robot2/odom", -2.0), kTf);
  EXPECT_FALSE(frames.find("odom", "laser", 1.0));
}

TEST(FrameTree, KnowsInWhichFrameAFrameHasMoved) {
  FrameTree frames;
  frames.add(moved(1.0, "world", "base_link", 0.0), kTf);
  frames.add(moved(1.0, "base_link", "laser", 0.3), kTf);
  frames.add(moved(1.1, "world", "base_link", 0.1), kTf);
  frames.add(moved(1.1, "base_link", "laser", 0.3), kTf);
  const auto above = frames.ancestors("laser", 1.1);
  ASSERT_EQ(above.size(), 3U);
  EXPECT_FALSE(above[1].has_moved);
  EXPECT_EQ(above[2].name, "world");
  EXPECT_TRUE(above[2].has_moved);
  EXPECT_NEAR(above[2].T_ancestor_frame->transform.translation().x(), 0.4, 1e-12);
}

TEST(FrameTree, PutsASecondParentBelowAFrame) {
  FrameTree frames;
  frames.add(moved(1.0, "base_link", "laser", 0.3), kStatic);
  for (const double stamp : {1.0, 1.1, 1.2}) {
    frames.add(moved(stamp, "odom", "base_link", stamp), kTf);
    frames.add(moved(stamp, "map", "base_link", 7.0), kTf);
  }
  EXPECT_NEAR(frames.find("odom", "laser", 1.15)->transform.translation().x(), 1.45, 1e-12);
  EXPECT_NEAR(frames.find("map", "laser", 1.15)->transform.translation().x(), 7.3, 1e-12);
}

TEST(FrameTree, PassesOverASecondParentThatHasAParent) {
  FrameTree frames;
  frames.add(moved(1.0, "base_link", "laser", 0.3), kStatic);
  frames.add(moved(1.0, "world", "odom", 1.0), kTf);
  frames.add(moved(1.0, "map", "base_link", 7.0), kTf);
  frames.add(moved(1.0, "odom", "base_link", 2.0), kTf);
  EXPECT_NEAR(frames.find("map", "laser", 1.0)->transform.translation().x(), 7.3, 1e-12);
  EXPECT_FALSE(frames.find("odom", "laser", 1.0));
}

TEST(FrameTree, PassesOverASecondParentThatIsAboveAlready) {
  FrameTree frames;
  frames.add(moved(1.0, "base_footprint", "base_link", 0.1), kStatic);
  frames.add(moved(1.0, "odom", "base_footprint", 2.0), kTf);
  frames.add(moved(1.0, "odom", "base_link", 2.2), kTf);  // of a filter beside the wheels
  frames.add(moved(1.0, "map", "odom", 5.0), kTf);
  EXPECT_EQ(frames.ancestors("base_link", 1.0).size(), 4U);
  EXPECT_NEAR(frames.find("map", "base_link", 1.0)->transform.translation().x(), 7.1, 1e-12);
}

TEST(FrameTree, ReplacesAParentThatIsNoLongerPublished) {
  FrameTree frames;
  frames.add(moved(1.0, "gripper", "box", 0.3), kTf);
  frames.add(moved(9.0, "table", "box", 0.5), kTf);
  EXPECT_NEAR(frames.find("table", "box", 9.0)->transform.translation().x(), 0.5, 1e-12);
  EXPECT_FALSE(frames.find("gripper", "box", 9.0));
}

TEST(FrameTree, ComesToAnEndInACycle) {
  FrameTree frames;
  frames.add(moved(1.0, "a", "b", 1.0), kStatic);
  frames.add(moved(1.0, "b", "a", 1.0), kStatic);
  EXPECT_FALSE(frames.find("map", "a", 1.0));
}

TEST(FrameTree, StartsAnewWhenTheClockWasSetBack) {
  FrameTree frames;
  frames.add(moved(1000.0, "odom", "laser", 1.0), kTf);
  frames.add(moved(5.0, "odom", "laser", 2.0), kTf);
  const auto found = frames.find("odom", "laser", 5.0);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->transform.translation().x(), 2.0);
}

}  // namespace
}  // namespace cornerfix

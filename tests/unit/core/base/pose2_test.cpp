#include <cornerfix/pose2.hpp>

#include <gtest/gtest.h>

namespace cornerfix {
namespace {

using std::numbers::pi;

TEST(WrapAngle, KeepsPlusPiAndFoldsMinusPi) {
  EXPECT_DOUBLE_EQ(wrap_angle(pi), pi);
  EXPECT_DOUBLE_EQ(wrap_angle(-pi), pi);
  EXPECT_NEAR(wrap_angle(3.0 * pi + 0.1), -pi + 0.1, 1e-12);
}

TEST(Pose2, ComposesWithItsInverseToIdentity) {
  const Pose2 T{1.5, -2.0, 2.9};
  const Pose2 identity = T * inverse(T);
  EXPECT_NEAR(identity.x, 0.0, 1e-12);
  EXPECT_NEAR(identity.y, 0.0, 1e-12);
  EXPECT_NEAR(identity.yaw, 0.0, 1e-12);
}

TEST(Pose2, TakesAPointThroughTwoFramesAsThroughTheirProduct) {
  const Pose2 T_a_b{1.0, 2.0, 0.7};
  const Pose2 T_b_c{-3.0, 0.5, -2.8};
  const Point2 p{0.3, -0.4};
  EXPECT_LT(((T_a_b * T_b_c) * p - T_a_b * (T_b_c * p)).norm(), 1e-12);
}

}  // namespace
}  // namespace cornerfix

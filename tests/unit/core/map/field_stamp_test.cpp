#include "core/src/map/field_stamp.hpp"

#include <gtest/gtest.h>

#include "core/src/map/distance_field.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

constexpr double kRadius = 0.5;

DistanceField empty_field() { return {{-5.0, -5.0, 0.0}, 0.1, 100, 100}; }

double distance_at(const DistanceField& field, const Point2& point) {
  return field.nearest(field.T_grid_frame() * point);
}

LaserScan wall_ahead() {
  const auto scene = testing::SceneBuilder().wall({2.0, -3.0}, {2.0, 3.0});
  return testing::simulate_scan(scene, {.beams = 90}, {});
}

TEST(FieldStamp, DrawsAWallBetweenNeighbouringReturns) {
  DistanceField field = empty_field();
  stamp_scan(field, wall_ahead(), {}, kRadius, 10.0);
  for (double y = -1.5; y <= 1.5; y += 0.05) EXPECT_LE(distance_at(field, {2.0, y}), 0.1) << y;
  EXPECT_NEAR(distance_at(field, {1.7, 0.0}), 0.3, 0.1);
  EXPECT_NEAR(distance_at(field, {0.0, 0.0}), DistanceField::kMaxDistance, 1e-6);
}

TEST(FieldStamp, TakesTheLasersPose) {
  DistanceField field = empty_field();
  stamp_scan(field, wall_ahead(), {0.0, 0.0, 1.5707963}, kRadius, 10.0);
  EXPECT_LE(distance_at(field, {0.0, 2.0}), 0.1);
  EXPECT_NEAR(distance_at(field, {2.0, 0.0}), DistanceField::kMaxDistance, 1e-6);
}

TEST(FieldStamp, LeavesOutReturnsBeyondTheRange) {
  DistanceField field = empty_field();
  stamp_scan(field, wall_ahead(), {}, kRadius, 1.9);
  EXPECT_NEAR(distance_at(field, {2.0, 0.0}), DistanceField::kMaxDistance, 1e-6);
}

TEST(FieldStamp, DrawsNothingAcrossAGap) {
  const auto scene =
      testing::SceneBuilder().wall({2.0, -3.0}, {2.0, -0.6}).wall({2.0, 0.6}, {2.0, 3.0});
  DistanceField field = empty_field();
  stamp_scan(field, testing::simulate_scan(scene, {.beams = 360}, {}), {}, 0.3, 10.0);
  EXPECT_LE(distance_at(field, {2.0, 1.0}), 0.1);
  EXPECT_NEAR(distance_at(field, {2.0, 0.0}), DistanceField::kMaxDistance, 1e-6);
}

}  // namespace
}  // namespace cornerfix

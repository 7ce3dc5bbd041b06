#include "bench/rivals/loam_corners.hpp"

#include <gtest/gtest.h>

#include "support/scan_simulator.hpp"

namespace cornerfix::bench {
namespace {

using cornerfix::testing::SceneBuilder;

LaserScan scan_of(const SceneBuilder& scene, const Pose2& pose) {
  return cornerfix::testing::simulate_scan(scene, {.beams = 1440, .range_max_m = 10.0}, pose);
}

TEST(LoamCorners, FindsTheCornersOfARoom) {
  const LaserScan scan = scan_of(SceneBuilder().room({-2, -2}, {3, 2}), {});
  const auto corners = extract_loam_corners(scan, vfp_params_for(scan.angle_increment));
  for (const Point2& corner : {Point2(-2, -2), Point2(3, -2), Point2(-2, 2), Point2(3, 2)}) {
    const bool found = std::ranges::any_of(
        corners, [&](const Feature& feature) { return (feature.position - corner).norm() < 0.1; });
    EXPECT_TRUE(found) << corner.transpose();
  }
}

TEST(LoamCorners, TakesTheEndOfAWallForACorner) {
  const LaserScan scan = scan_of(SceneBuilder().wall({2, -1}, {2, 1}), {});
  EXPECT_FALSE(extract_loam_corners(scan, vfp_params_for(scan.angle_increment)).empty());
}

}  // namespace
}  // namespace cornerfix::bench

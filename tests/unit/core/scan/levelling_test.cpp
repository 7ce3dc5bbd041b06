#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <cornerfix/laser_scan.hpp>

#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using std::numbers::pi;
constexpr std::size_t kBeams = 720;
constexpr double kDegree = pi / 180.0;

testing::SceneBuilder levelled_room() {
  return testing::SceneBuilder().room({-3.0, -2.0}, {5.0, 4.0});
}

/// What a tilted laser in the middle of levelled_room() measures: its beams leave the plane, and
/// walls are vertical.
LaserScan tilted_scan(const LidarTilt& tilt) {
  LaserScan scan = testing::simulate_scan(levelled_room(), {.beams = kBeams}, {});
  for (std::size_t beam = 0; beam < kBeams; ++beam) {
    const double c = std::cos(scan.bearing(beam));
    const double s = std::sin(scan.bearing(beam));
    const double x = std::cos(tilt.pitch) * c + std::sin(tilt.pitch) * std::sin(tilt.roll) * s;
    const double y = std::cos(tilt.roll) * s;
    const double flat = levelled_room().range(Point2::Zero(), std::atan2(y, x));
    scan.ranges[beam] = static_cast<float>(flat / std::hypot(x, y));
  }
  return scan;
}

/// The greatest distance of a return from the walls of levelled_room() [m].
double greatest_error(const LaserScan& scan) {
  double greatest = 0.0;
  for (const Point2& p : returns_as_points(scan)) {
    const double to_wall = std::min({std::abs(p.x() + 3.0), std::abs(p.x() - 5.0),
                                     std::abs(p.y() + 2.0), std::abs(p.y() - 4.0)});
    greatest = std::max(greatest, to_wall);
  }
  return greatest;
}

TEST(Levelling, LeavesALevelScanAsItIs) {
  const LaserScan scan = testing::simulate_scan(levelled_room(), {.beams = kBeams}, {});
  const LaserScan level = levelled(scan, {});
  EXPECT_EQ(level.ranges, scan.ranges);
  EXPECT_EQ(level.angle_min, scan.angle_min);
  EXPECT_EQ(level.angle_increment, scan.angle_increment);
}

TEST(Levelling, TurnsAScanThatWasTakenUpsideDown) {
  for (const double roll : {pi, -pi}) {
    const LaserScan level = levelled(tilted_scan({.roll = pi}), {.roll = roll});
    EXPECT_LT(greatest_error(level), 0.01);
    EXPECT_EQ(returns_as_points(level).size(), kBeams);
    EXPECT_LT(level.angle_increment, 0.0);
  }
}

TEST(Levelling, ProjectsATiltedScanToThePlane) {
  for (const LidarTilt& tilt :
       {LidarTilt{.roll = 10.0 * kDegree}, LidarTilt{.pitch = -10.0 * kDegree},
        LidarTilt{.roll = -7.0 * kDegree, .pitch = 8.0 * kDegree},
        LidarTilt{.roll = pi - 6.0 * kDegree, .pitch = 5.0 * kDegree}}) {
    SCOPED_TRACE(std::to_string(tilt.roll) + ", " + std::to_string(tilt.pitch));
    const LaserScan scan = tilted_scan(tilt);
    const LaserScan level = levelled(scan, tilt);
    EXPECT_LT(greatest_error(level), 0.05) << "half a beam's width";
    EXPECT_GT(returns_as_points(level).size(), kBeams * 95 / 100);
  }
}

TEST(Levelling, KeepsBeamsWithoutReturn) {
  LaserScan scan = tilted_scan({.pitch = 0.1});
  for (std::size_t beam = 100; beam < 200; ++beam)
    scan.ranges[beam] = std::numeric_limits<float>::infinity();
  const LaserScan level = levelled(scan, {.pitch = 0.1});
  EXPECT_NEAR(static_cast<double>(returns_as_points(level).size()), kBeams - 100.0, 30.0);
}

}  // namespace
}  // namespace cornerfix

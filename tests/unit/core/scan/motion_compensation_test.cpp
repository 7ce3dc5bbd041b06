#include <cornerfix/laser_scan.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cornerfix {
namespace {

using std::numbers::pi;
constexpr std::size_t kMovingBeams = 360;
constexpr double kScanSeconds = 0.2;
constexpr double kTimeIncrement = kScanSeconds / kMovingBeams;

/// How far it is to the walls of a room of 6 x 4 m about the origin.
double range_in_room(const Point2& from, double heading) {
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  const double to_x = c == 0.0 ? 1e9 : ((c > 0.0 ? 3.0 : -3.0) - from.x()) / c;
  const double to_y = s == 0.0 ? 1e9 : ((s > 0.0 ? 2.0 : -2.0) - from.y()) / s;
  return std::min(to_x, to_y);
}

/// A scan by a laser that begins at the origin and moves by `T_begin_end` while it takes it.
LaserScan scan_on_the_move(const Pose2& T_begin_end) {
  LaserScan scan;
  scan.angle_min = -pi;
  scan.angle_increment = 2.0 * pi / kMovingBeams;
  scan.range_max = 20.0;
  for (std::size_t beam = 0; beam < kMovingBeams; ++beam) {
    const double share = static_cast<double>(beam) / kMovingBeams;
    const Point2 position = share * T_begin_end.translation();
    scan.ranges.push_back(
        static_cast<float>(range_in_room(position, scan.bearing(beam) + share * T_begin_end.yaw)));
  }
  return scan;
}

/// The greatest error of a return, seen from the origin [m].
double greatest_wall_error(const LaserScan& scan) {
  double greatest = 0.0;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.has_return(beam)) continue;
    const Point2 point = static_cast<double>(scan.ranges[beam]) *
                         Point2(std::cos(scan.bearing(beam)), std::sin(scan.bearing(beam)));
    const double to_wall =
        std::min({std::abs(std::abs(point.x()) - 3.0), std::abs(std::abs(point.y()) - 2.0)});
    greatest = std::max(greatest, to_wall);
  }
  return greatest;
}

std::size_t returns(const LaserScan& scan) { return returns_as_points(scan).size(); }

TEST(MotionCompensation, StraightensAScanOfARobotThatTurns) {
  const Pose2 turn{0.0, 0.0, 0.3};
  const LaserScan crooked = scan_on_the_move(turn);
  EXPECT_GT(greatest_wall_error(crooked), 0.1);
  const LaserScan straight = straightened(crooked, {turn, kScanSeconds, kTimeIncrement});
  EXPECT_LT(greatest_wall_error(straight), 1e-5);
  EXPECT_FALSE(validate(straight));
}

TEST(MotionCompensation, StraightensAScanOfARobotThatDrives) {
  const Pose2 drive{0.16, 0.05, 0.1};
  const LaserScan crooked = scan_on_the_move(drive);
  EXPECT_GT(greatest_wall_error(crooked), 0.1);
  const LaserScan straight = straightened(crooked, {drive, kScanSeconds, kTimeIncrement});
  // Half a beam's width on a wall seen at a slant remains.
  EXPECT_LT(greatest_wall_error(straight), 0.06);
  EXPECT_GT(returns(straight), 330U);
}

TEST(MotionCompensation, TakesAReversedScanFromItsLastBeam) {
  const Pose2 turn{0.0, 0.0, -0.2};
  LaserScan crooked = scan_on_the_move(turn);
  crooked.angle_min += static_cast<double>(kMovingBeams - 1) * crooked.angle_increment;
  crooked.angle_increment = -crooked.angle_increment;
  std::reverse(crooked.ranges.begin(), crooked.ranges.end());
  crooked.angle_min = -(crooked.angle_min);
  crooked.angle_increment = -crooked.angle_increment;
  // Now the last beam was taken first, mirrored: the robot turns the other way.
  const LaserScan straight =
      straightened(crooked, {{0.0, 0.0, 0.2}, kScanSeconds, -kTimeIncrement});
  EXPECT_LT(greatest_wall_error(straight), 1e-5);
}

TEST(MotionCompensation, LeavesAScanAsItIsWhenTheRobotStands) {
  LaserScan scan = scan_on_the_move({});
  scan.ranges[7] = std::numeric_limits<float>::quiet_NaN();
  const LaserScan same = straightened(scan, {{}, kScanSeconds, kTimeIncrement});
  EXPECT_EQ(same.angle_increment, scan.angle_increment);
  EXPECT_FALSE(same.has_return(7));
  for (std::size_t beam = 0; beam < kMovingBeams; ++beam) {
    if (beam == 7) continue;
    EXPECT_NEAR(same.ranges[beam], scan.ranges[beam], 1e-5F);
  }
}

TEST(MotionCompensation, LeavesAScanAsItIsWhenTurningUndoesItsAngles) {
  const LaserScan scan = scan_on_the_move({});
  const LaserScan same = straightened(scan, {{0.0, 0.0, -7.0}, kScanSeconds, kTimeIncrement});
  EXPECT_EQ(same.ranges, scan.ranges);
}

TEST(MotionCompensation, BelievesNoRobotThatFlies) {
  EXPECT_TRUE(is_plausible({{1.0, 0.0, 1.0}, 0.2, 0.0}));
  EXPECT_FALSE(is_plausible({{3.0, 0.0, 0.0}, 0.2, 0.0}));
  EXPECT_FALSE(is_plausible({{0.0, 0.0, -3.0}, 0.2, 0.0}));
}

}  // namespace
}  // namespace cornerfix

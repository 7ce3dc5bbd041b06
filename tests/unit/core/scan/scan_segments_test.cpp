#include "core/src/scan/scan_segments.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::Lidar;
using testing::SceneBuilder;
using testing::simulate_scan;

using std::numbers::pi;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<ScanSegment> cut(const LaserScan& scan) { return cut_into_segments(scan, {}); }

/// An unbroken turn around a lidar that looks along +x in a room of 8 m by 6 m.
LaserScan scan_in_a_room() {
  return simulate_scan(SceneBuilder().room({0, 0}, {8, 6}), {}, {3.0, 2.0, 0.0});
}

TEST(ScanSegments, PutPointsWhereTheReturnsAre) {
  const LaserScan scan = scan_in_a_room();
  const std::vector<Point2> expected = returns_as_points(scan);
  const auto segments = cut(scan);
  ASSERT_EQ(segments.size(), 1U);
  ASSERT_EQ(segments[0].points.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_LT((segments[0].points[i].position - expected[i]).norm(), 1e-9);
    EXPECT_EQ(segments[0].points[i].beam, i);
  }
}

TEST(ScanSegments, CloseARoomSeenAllRound) {
  const auto segments = cut(scan_in_a_room());
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_TRUE(segments[0].closed);
}

TEST(ScanSegments, StayOpenWithoutAFullTurn) {
  const Lidar lidar{.beams = 1081, .field_of_view_rad = 1.5 * pi};
  const auto scan = simulate_scan(SceneBuilder().room({0, 0}, {8, 6}), lidar, {3.0, 2.0, 0.0});
  const auto segments = cut(scan);
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_FALSE(segments[0].closed);
}

TEST(ScanSegments, CutWhereABoxStandsBeforeAWall) {
  const auto scene = SceneBuilder().wall({5, -3}, {5, 3}).wall({3, -0.5}, {3, 0.5});
  const auto segments = cut(simulate_scan(scene, {}, {}));
  EXPECT_EQ(segments.size(), 3U);
}

TEST(ScanSegments, JoinAWallAcrossTheSeamAtPi) {
  const auto scene = SceneBuilder().wall({-3, -1}, {-3, 1}).wall({4, -1}, {4, 1});
  const auto segments = cut(simulate_scan(scene, {}, {}));
  ASSERT_EQ(segments.size(), 2U);
  const auto behind = std::ranges::find_if(
      segments, [](const ScanSegment& s) { return s.points[0].position.x() < 0.0; });
  ASSERT_NE(behind, segments.end());
  EXPECT_NEAR(behind->points.front().position.y(), 1.0, 0.02);
  EXPECT_NEAR(behind->points.back().position.y(), -1.0, 0.02);
}

TEST(ScanSegments, GoOnOverASingleBeamWithoutReturn) {
  LaserScan scan = scan_in_a_room();
  scan.ranges[700] = kNan;
  const auto segments = cut(scan);
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_EQ(segments[0].points.size(), 1439U);
}

TEST(ScanSegments, DropAPieceSeenAtAGrazingAngle) {
  const auto scene = SceneBuilder().wall({2.0, 0.0}, {2.6, 0.05});
  EXPECT_TRUE(cut(simulate_scan(scene, {.beams = 14400}, {})).empty());
  EXPECT_EQ(cut(simulate_scan(scene.moved({0.0, -2.0, 0.0}), {.beams = 14400}, {})).size(), 1U);
}

TEST(ScanSegments, KeepARoomWhoseDoorLiesAlongABeam) {
  // Both ends of the piece are at the door, one behind the other.
  const auto scene = SceneBuilder()
                         .wall({2, 0.2}, {2, 3})
                         .wall({2, 3}, {-2, 3})
                         .wall({-2, 3}, {-2, -3})
                         .wall({-2, -3}, {3, -3})
                         .wall({3, -3}, {3, 0.1});
  EXPECT_EQ(cut(simulate_scan(scene, {}, {})).size(), 1U);
}

TEST(ScanSegments, DropPiecesOfTooFewPoints) {
  LaserScan scan = scan_in_a_room();
  std::fill(scan.ranges.begin(), scan.ranges.end(), kNan);
  std::fill_n(scan.ranges.begin() + 100, 4, 2.0F);
  EXPECT_TRUE(cut(scan).empty());
  scan.ranges[104] = 2.0F;
  EXPECT_EQ(cut(scan).size(), 1U);
}

TEST(ScanSegments, AreNoneWithoutReturns) {
  LaserScan scan = scan_in_a_room();
  std::fill(scan.ranges.begin(), scan.ranges.end(), kNan);
  EXPECT_TRUE(cut(scan).empty());
  scan.ranges.clear();
  EXPECT_TRUE(cut(scan).empty());
  scan.ranges = {1.0F};
  EXPECT_TRUE(cut(scan).empty());
}

TEST(ScanSegments, AreTheSameWhicheverWayTheLidarTurns) {
  const auto scene = testing::figure7_room();
  LaserScan scan = simulate_scan(scene, {.field_of_view_rad = 1.4 * pi}, {7.5, 5.0, 1.0});
  const auto counterclockwise = cut(scan);
  scan.angle_min = scan.bearing(scan.ranges.size() - 1);
  scan.angle_increment = -scan.angle_increment;
  std::ranges::reverse(scan.ranges);
  EXPECT_EQ(cut(scan).size(), counterclockwise.size());
}

TEST(ScanSegmentParams, NameTheBrokenLimit) {
  EXPECT_FALSE(validate(ScanSegmentParams{}));
  EXPECT_EQ(validate(ScanSegmentParams{.gap_m = 0.0})->field, "gap_m");
  EXPECT_EQ(validate(ScanSegmentParams{.min_incidence_rad = 0.0})->field, "min_incidence_rad");
  EXPECT_EQ(validate(ScanSegmentParams{.min_points = 1})->field, "min_points");
}

}  // namespace
}  // namespace cornerfix

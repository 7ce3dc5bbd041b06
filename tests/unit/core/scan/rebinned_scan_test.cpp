#include "core/src/scan/rebinned_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace cornerfix {
namespace {

constexpr double kBeamStep = 0.1;  // [rad] between beams.

/// Five beams from -0.2 to 0.2 rad.
LaserScan five_beams() {
  LaserScan scan;
  scan.angle_min = -2.0 * kBeamStep;
  scan.angle_increment = kBeamStep;
  scan.range_max = 20.0;
  scan.ranges.assign(5, 7.0F);
  return scan;
}

Point2 point_at(double bearing, double range) {
  return {range * std::cos(bearing), range * std::sin(bearing)};
}

TEST(RebinnedScan, HasNoReturnsWhereNothingWasPut) {
  const LaserScan scan = RebinnedScan(five_beams()).finish();
  ASSERT_EQ(scan.ranges.size(), 5U);
  for (const float range : scan.ranges) EXPECT_TRUE(std::isnan(range));
  EXPECT_EQ(scan.angle_min, five_beams().angle_min);
}

TEST(RebinnedScan, MovesAReturnToTheBeamOfItsBearing) {
  RebinnedScan rebinned(five_beams());
  rebinned.put(1, point_at(0.98 * kBeamStep, 4.0));
  const LaserScan scan = std::move(rebinned).finish();
  EXPECT_TRUE(std::isnan(scan.ranges[1]));
  EXPECT_FLOAT_EQ(scan.ranges[3], 4.0F);
}

TEST(RebinnedScan, DropsAReturnOutsideOfItsBeams) {
  RebinnedScan rebinned(five_beams());
  rebinned.put(4, point_at(3.0 * kBeamStep, 4.0));
  const LaserScan scan = std::move(rebinned).finish();
  for (const float range : scan.ranges) EXPECT_TRUE(std::isnan(range));
}

TEST(RebinnedScan, KeepsTheNearestOfSeveralReturns) {
  RebinnedScan rebinned(five_beams());
  rebinned.put(2, point_at(0.0, 5.0));
  rebinned.put(3, point_at(0.0, 3.0));
  rebinned.put(1, point_at(0.0, 4.0));
  rebinned.put_no_return(2);
  EXPECT_FLOAT_EQ(std::move(rebinned).finish().ranges[2], 3.0F);
}

TEST(RebinnedScan, FillsOneEmptyBeamWithinASurfaceOnly) {
  RebinnedScan surface(five_beams());
  surface.put(1, point_at(-kBeamStep, 4.0));
  surface.put(3, point_at(kBeamStep, 4.2));
  EXPECT_FLOAT_EQ(std::move(surface).finish().ranges[2], 4.1F);

  RebinnedScan edge(five_beams());
  edge.put(1, point_at(-kBeamStep, 4.0));
  edge.put(3, point_at(kBeamStep, 6.0));
  EXPECT_TRUE(std::isnan(std::move(edge).finish().ranges[2]));
}

TEST(RebinnedScan, LeavesABeamWithoutReturnEmpty) {
  RebinnedScan rebinned(five_beams());
  rebinned.put(1, point_at(-kBeamStep, 4.0));
  rebinned.put_no_return(2);
  rebinned.put(3, point_at(kBeamStep, 4.0));
  EXPECT_TRUE(std::isnan(std::move(rebinned).finish().ranges[2]));
}

}  // namespace
}  // namespace cornerfix

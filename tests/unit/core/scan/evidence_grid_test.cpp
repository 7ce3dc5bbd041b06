#include "core/src/scan/evidence_grid.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::SceneBuilder;

using std::numbers::pi;
constexpr double kEvidenceCell = EvidenceGridParams{}.resolution_m;

SceneBuilder room_with_box() {
  return SceneBuilder().room({-4.0, -3.0}, {5.0, 3.5}).box({2.0, 1.5}, {0.7, 0.9}, 0.5);
}

LaserScan scan_at(const SceneBuilder& scene, const Pose2& pose, double range_max_m = 30.0) {
  return testing::simulate_scan(scene, {.beams = 720, .range_max_m = range_max_m}, pose);
}

/// As collected, in an order of its own.
std::vector<Point2> sorted(std::vector<Point2> points) {
  const auto key = [](const Point2& p) { return std::pair(std::lround(p.x() * 1e4), p.y()); };
  std::ranges::sort(points, {}, key);
  return points;
}

void expect_same(const std::vector<Point2>& actual, const std::vector<Point2>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  const std::vector<Point2> a = sorted(actual);
  const std::vector<Point2> e = sorted(expected);
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_LT((a[i] - e[i]).norm(), 1e-4) << a[i].transpose() << " is not " << e[i].transpose();
  }
}

void expect_same(const Evidence& actual, const Evidence& expected) {
  expect_same(actual.ends, expected.ends);
  expect_same(actual.free, expected.free);
}

TEST(EvidenceGrid, ARemovedScanLeavesNoTrace) {
  const LaserScan first = scan_at(room_with_box(), {0.0, 0.0, 0.0});
  const LaserScan second = scan_at(room_with_box(), {1.0, -1.0, 0.8});
  EvidenceGrid grid;
  grid.add(first, {});
  const Evidence before = grid.collect();
  grid.add(second, {1.0, -1.0, 0.8});
  EXPECT_GT(grid.collect().ends.size(), before.ends.size());
  grid.remove(second, {1.0, -1.0, 0.8});
  expect_same(grid.collect(), before);
}

TEST(EvidenceGrid, IsEmptyWhenAllScansAreRemoved) {
  EvidenceGrid grid;
  const LaserScan scan = scan_at(room_with_box(), {});
  grid.add(scan, {});
  grid.remove(scan, {});
  EXPECT_TRUE(grid.collect().ends.empty());
  EXPECT_TRUE(grid.collect().free.empty());
}

/// A robot that comes back to a place it has forgotten sees it as if for the first time.
TEST(EvidenceGrid, ARemovedScanAddedAgainCountsOnce) {
  EvidenceGrid once;
  EvidenceGrid again;
  const LaserScan scan = scan_at(room_with_box(), {});
  once.add(scan, {});
  again.add(scan, {});
  again.remove(scan, {});
  again.add(scan, {});
  expect_same(again.collect(), once.collect());
}

TEST(EvidenceGrid, ACellHasOneEnd) {
  EvidenceGrid grid;
  for (int i = 0; i < 5; ++i) {
    const Pose2 pose{0.1 * i, 0.05 * i, 0.1 * i};
    grid.add(scan_at(room_with_box(), pose), pose);
  }
  std::set<std::pair<long, long>> cells;
  for (const Point2& end : grid.collect().ends) {
    const auto cell = std::pair(std::lround(std::floor(end.x() / kEvidenceCell)),
                                std::lround(std::floor(end.y() / kEvidenceCell)));
    EXPECT_TRUE(cells.insert(cell).second) << end.transpose();
  }
}

TEST(EvidenceGrid, ThereIsNothingNewInTheSameScanTwice) {
  EvidenceGrid once;
  EvidenceGrid twice;
  const LaserScan scan = scan_at(room_with_box(), {});
  once.add(scan, {});
  twice.add(scan, {});
  twice.add(scan, {});
  expect_same(twice.collect(), once.collect());
}

TEST(EvidenceGrid, EndsLieOnWalls) {
  const Pose2 pose{1.0, -1.0, 0.8};
  EvidenceGrid grid;
  grid.add(scan_at(room_with_box(), pose), pose);
  const std::vector<Point2> ends = grid.collect().ends;
  EXPECT_GT(ends.size(), 50U);
  for (const Point2& end : ends) {
    EXPECT_LT(room_with_box().distance_to_walls(end), 0.5 * kEvidenceCell) << end.transpose();
  }
}

TEST(EvidenceGrid, APersonWhoLeftIsLeftOut) {
  const SceneBuilder with_person = room_with_box().box({-1.5, 0.5}, {0.4, 0.4}, 0.2);
  EvidenceGrid grid;
  grid.add(scan_at(with_person, {}), {});
  const auto near_person = [&] {
    return std::ranges::count_if(grid.collect().ends, [](const Point2& end) {
      return (end - Point2(-1.5, 0.5)).norm() < 0.5;
    });
  };
  EXPECT_GT(near_person(), 0);
  for (int i = 0; i < 6; ++i) grid.add(scan_at(room_with_box(), {}), {});
  EXPECT_EQ(near_person(), 0);
}

TEST(EvidenceGrid, WhatIsFreeIsFree) {
  EvidenceGrid grid;
  for (int i = 0; i < 6; ++i) {
    const Pose2 pose{-2.0 + 0.6 * i, -1.0, 0.5 * i};
    grid.add(scan_at(room_with_box(), pose), pose);
  }
  const std::vector<Point2> free = grid.collect().free;
  EXPECT_GT(free.size(), 100U);
  for (const Point2& p : free) {
    EXPECT_GT(room_with_box().distance_to_walls(p), 0.05) << p.transpose();
    bool seen = false;  // some part of the cell
    for (int i = 0; i < 6 * 9; ++i) {
      const Point2 part = p + 0.45 * kEvidenceCell * Point2(i % 3 - 1, i / 3 % 3 - 1);
      seen = seen || room_with_box().sees({-2.0 + 0.6 * (i / 9), -1.0}, part);
    }
    EXPECT_TRUE(seen) << p.transpose();
  }
}

TEST(EvidenceGrid, ALongBeamPassesButDoesNotEnd) {
  const SceneBuilder wall = SceneBuilder().wall({35.0, -20.0}, {35.0, 20.0});
  EvidenceGrid grid;
  grid.add(scan_at(wall, {}, 60.0), {});
  const Evidence evidence = grid.collect();
  EXPECT_TRUE(evidence.ends.empty());
  EXPECT_FALSE(evidence.free.empty());
  const double reach = EvidenceGridParams{}.max_range_m + kEvidenceCell;
  for (const Point2& p : evidence.free) EXPECT_LT(p.norm(), reach);
}

TEST(EvidenceGrid, WhatLiesOutsideItsSquareIsCutOff) {
  const LaserScan scan = scan_at(room_with_box(), {});
  EvidenceGrid grid({0.0, 0.0}, {.extent_m = 4.0});
  grid.add(scan, {});
  const Evidence evidence = grid.collect();
  EXPECT_FALSE(evidence.free.empty());
  for (const Point2& p : evidence.ends) EXPECT_LE(p.cwiseAbs().maxCoeff(), 2.0);
  for (const Point2& p : evidence.free) EXPECT_LE(p.cwiseAbs().maxCoeff(), 2.0);
  grid.remove(scan, {});
  EXPECT_TRUE(grid.collect().free.empty());
}

TEST(EvidenceGrid, FollowsThePoseOfTheScan) {
  const LaserScan scan = scan_at(room_with_box(), {});
  EvidenceGrid here;
  EvidenceGrid there({8.0, -4.0});
  here.add(scan, {});
  there.add(scan, {8.0, -4.0, 0.0});
  Evidence moved = here.collect();
  for (Point2& p : moved.ends) p += Point2(8.0, -4.0);
  for (Point2& p : moved.free) p += Point2(8.0, -4.0);
  expect_same(there.collect(), moved);
}

TEST(EvidenceGrid, ScansWithoutReturnsSayNothing) {
  LaserScan scan{
      .angle_min = -pi, .angle_increment = 0.01, .range_min = 0.1, .range_max = 30.0, .ranges = {}};
  EvidenceGrid grid;
  grid.add(scan, {});
  scan.ranges.assign(600, std::numeric_limits<float>::quiet_NaN());
  grid.add(scan, {});
  EXPECT_TRUE(grid.collect().ends.empty());
  EXPECT_TRUE(grid.collect().free.empty());
}

TEST(EvidenceGrid, AClockwiseLidarSaysTheSame) {
  const LaserScan scan = scan_at(room_with_box(), {});
  LaserScan clockwise = scan;
  clockwise.angle_min = scan.bearing(scan.ranges.size() - 1);
  clockwise.angle_increment = -scan.angle_increment;
  std::ranges::reverse(clockwise.ranges);
  const EvidenceGridParams every_beam{.min_beam_spacing_rad = 0.0};
  EvidenceGrid one({0, 0}, every_beam);
  EvidenceGrid other({0, 0}, every_beam);
  one.add(scan, {});
  other.add(clockwise, {});
  expect_same(other.collect(), one.collect());
}

}  // namespace
}  // namespace cornerfix

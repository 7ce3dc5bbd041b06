#include "core/src/matching/triangle_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;

constexpr TriangleLimits kLimits{.min_side_m = 1.0, .max_side_m = 20.0, .tolerance_m = 0.15};
const Point2 kA(0.0, 0.0), kB(6.0, 0.0), kC(4.5, 3.0);

TEST(TriangleTable, SortsTheSidesAndKnowsTheSense) {
  const auto triangle = triangle_of(kA, kB, kC, kLimits);
  ASSERT_TRUE(triangle);
  EXPECT_GT(triangle->sides[0], triangle->sides[1]);
  EXPECT_GT(triangle->sides[1], triangle->sides[2]);
  const auto mirrored = triangle_of({0, 0}, {6, 0}, {4.5, -3.0}, kLimits);
  ASSERT_TRUE(mirrored);
  EXPECT_NE(mirrored->counter_clockwise, triangle->counter_clockwise);
}

TEST(TriangleTable, GivesOneFrameInWhateverOrderThePointsCome) {
  const auto triangle = triangle_of(kA, kB, kC, kLimits);
  const auto other = triangle_of(kC, kA, kB, kLimits);
  ASSERT_TRUE(triangle && other);
  EXPECT_THAT(other->frame, IsPoseNear(triangle->frame, 1e-9, 1e-9));
}

TEST(TriangleTable, LeavesOutTrianglesThatDefineNoPose) {
  EXPECT_FALSE(triangle_of({0, 0}, {0.5, 0}, {0.4, 3}, kLimits)) << "a side too short";
  EXPECT_FALSE(triangle_of({0, 0}, {25, 0}, {3, 4}, kLimits)) << "a side too long";
  EXPECT_FALSE(triangle_of({0, 0}, {4, 0}, {2, 3.46}, kLimits)) << "equal sides";
  EXPECT_FALSE(triangle_of({0, 0}, {3, 0}, {8, 0.1}, kLimits)) << "nearly no area";
}

TEST(TriangleTable, FindsTheTriangleThatWasMoved) {
  const Point2 points[] = {kA, kB, kC, {15.0, 9.0}, {11.0, 14.0}};
  const TriangleTable table(PointGrid(points, 0.15), kLimits, 18);
  EXPECT_GT(table.size(), 0U);
  const Pose2 T{40.0, -3.0, 2.0};
  const auto moved = triangle_of(T * kA, T * kB, T * kC, kLimits);
  ASSERT_TRUE(moved);
  std::vector<Pose2> frames;
  table.find_congruent(*moved, frames);
  ASSERT_FALSE(frames.empty());
  EXPECT_THAT(frames, ::testing::Contains(
                          IsPoseNear(triangle_of(kA, kB, kC, kLimits)->frame, 0.01, 0.001)));
}

TEST(TriangleTable, FindsNothingForAMirroredTriangle) {
  const Point2 points[] = {kA, kB, kC};
  const TriangleTable table(PointGrid(points, 0.15), kLimits, 18);
  const auto mirrored = triangle_of({0, 0}, {6, 0}, {4.5, -3.0}, kLimits);
  ASSERT_TRUE(mirrored);
  std::vector<Pose2> frames;
  table.find_congruent(*mirrored, frames);
  EXPECT_TRUE(frames.empty());
}

}  // namespace
}  // namespace cornerfix

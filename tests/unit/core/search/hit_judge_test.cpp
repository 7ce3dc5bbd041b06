#include "core/src/search/hit_judge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace cornerfix {
namespace {

/// A free room of 6 m x 4 m whose walls are the outermost cells of 0.2 m.
MapSketch room_sketch() {
  MapSketch sketch;
  sketch.cell_m = 0.2;
  sketch.width = 30;
  sketch.height = 20;
  sketch.levels.assign(MapSketch::level_bytes(sketch.width, sketch.height), 0);
  for (int row = 0; row < sketch.height; ++row) {
    for (int column = 0; column < sketch.width; ++column) {
      const bool is_wall = row == 0 || column == 0 || row == 19 || column == 29;
      const auto level = static_cast<unsigned>(is_wall ? HitLevel::kWall : HitLevel::kFree);
      const auto at = static_cast<std::size_t>(row * sketch.width + column);
      sketch.levels[at / 4] |= static_cast<std::uint8_t>(level << (2 * (at % 4)));
    }
  }
  return sketch;
}

/// The walls of the room as seen from a pose in it.
std::vector<Point2> hits_from(const Pose2& T_grid_base_link) {
  std::vector<Point2> hits;
  for (double x = 0.1; x < 6.0; x += 0.1) {
    hits.push_back(inverse(T_grid_base_link) * Point2(x, 0.1));
    hits.push_back(inverse(T_grid_base_link) * Point2(x, 3.9));
  }
  for (double y = 0.1; y < 4.0; y += 0.1) {
    hits.push_back(inverse(T_grid_base_link) * Point2(0.1, y));
    hits.push_back(inverse(T_grid_base_link) * Point2(5.9, y));
  }
  return hits;
}

const Pose2 kPoseInRoom{2.0, 1.4, 0.7};

TEST(HitJudge, GivesTheWeightOfAWallWhereAllHitsAreOnWalls) {
  const auto mean = HitJudge(hits_from(kPoseInRoom)).mean_at(room_sketch(), kPoseInRoom);
  ASSERT_TRUE(mean);
  EXPECT_NEAR(*mean, 0.41, 1e-6);
}

TEST(HitJudge, GivesUpWhereTheFirstHitsAreInFreeSpace) {
  const HitJudge judge(std::vector<Point2>{{1.0, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}});
  EXPECT_FALSE(judge.mean_at(room_sketch(), {3.0, 2.0, 0.0}));
}

TEST(HitJudge, KnowsNoPoseInUnknownSpace) {
  EXPECT_FALSE(HitJudge(hits_from(kPoseInRoom)).mean_at(room_sketch(), {-1.0, 1.0, 0.0}));
}

TEST(HitJudge, LeavesOutFarHits) {
  EXPECT_TRUE(HitJudge(std::vector<Point2>{{15.1, 0.0}}).empty());
  EXPECT_FALSE(HitJudge(std::vector<Point2>{{14.9, 0.0}}).empty());
}

TEST(HitJudge, MovesANearPoseToTheTrueOne) {
  const HitJudge judge(hits_from(kPoseInRoom));
  const Pose2 near = kPoseInRoom * Pose2{0.15, -0.1, 0.05};
  const auto mean = judge.mean_at(room_sketch(), near);
  ASSERT_TRUE(mean);
  const auto [refined_mean, refined] = judge.refined(room_sketch(), *mean, near);
  EXPECT_GT(refined_mean, *mean);
  EXPECT_LT(distance(refined, kPoseInRoom), distance(near, kPoseInRoom));
  EXPECT_NEAR(refined_mean, 0.41, 0.05);
}

}  // namespace
}  // namespace cornerfix

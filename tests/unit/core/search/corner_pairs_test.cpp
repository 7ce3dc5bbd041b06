#include "core/src/search/corner_pairs.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace cornerfix {
namespace {

TEST(CornerPairs, HaveTheSameClassWhereverTheyAreSeenFrom) {
  const OrientedCorner a{{1.0, 2.0}, 0.4, true};
  const OrientedCorner b{{4.1, 3.2}, -2.0, false};
  const Pose2 T{-7.0, 3.0, 2.2};
  const auto moved = [&](const OrientedCorner& one) {
    return OrientedCorner{T * one.position, wrap_angle(one.bisector + T.yaw), one.convex};
  };
  const auto here = corner_pair(a, b);
  const auto there = corner_pair(moved(a), moved(b));
  ASSERT_TRUE(here && there);
  std::vector<std::size_t> keys;
  keys_near(*here, keys);
  EXPECT_THAT(keys, ::testing::Contains(key_of(*there)));
  EXPECT_LT(distance(T * here->T_frame_pair, there->T_frame_pair), 1e-9);
  keys.clear();
  keys_near(*corner_pair(b, a), keys);
  EXPECT_THAT(keys, ::testing::Not(::testing::Contains(key_of(*here))));
}

TEST(CornerPairs, AreNeitherTooNearNorTooFar) {
  const OrientedCorner a{{0.0, 0.0}, 0.0, true};
  EXPECT_FALSE(corner_pair(a, {{0.5, 0.0}, 0.0, true}));
  EXPECT_FALSE(corner_pair(a, {{17.0, 0.0}, 0.0, true}));
  EXPECT_TRUE(corner_pair(a, {{15.9, 0.0}, 0.0, true}));
}

TEST(CornerPairs, OfNeighborsComeOnce) {
  std::vector<SketchCorner> corners;
  for (int i = 0; i < 10; ++i)
    corners.push_back({static_cast<float>(2 * i), 0.0F, 0.0F, 1.5F, true});
  const auto pairs = neighboring_pairs(corners, 2);
  EXPECT_THAT(pairs, ::testing::Contains(std::pair(0U, 1U)));
  EXPECT_THAT(pairs, ::testing::Each(::testing::Truly([](const auto& pair) {
                return pair.first < pair.second && pair.second - pair.first <= 2;
              })));
  EXPECT_EQ(std::ranges::adjacent_find(pairs), pairs.end());
}

TEST(CornerPairs, HaveKeysBelowTheirNumber) {
  const OrientedCorner a{{0.0, 0.0}, 3.1, true};
  for (const double distance_m : {1.0, 8.0, 15.99}) {
    const auto pair = corner_pair(a, {{distance_m, 0.0}, -3.1, true});
    ASSERT_TRUE(pair) << distance_m;
    EXPECT_LT(key_of(*pair), kPairKeys) << distance_m;
  }
}

}  // namespace
}  // namespace cornerfix

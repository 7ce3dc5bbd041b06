#include "core/src/acceptance/new_ground.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/src/search/map_index.hpp"
#include "support/map_maker.hpp"

namespace cornerfix {
namespace {

using testing::SceneBuilder;
using Verdict = NewGround::Verdict;

const testing::Lidar kLidar{.beams = 360, .noise_m = 0.01};

SceneBuilder two_rooms() {
  return SceneBuilder().room({0, 0}, {12, 6}).wall({6, 0}, {6, 2.5}).wall({6, 3.5}, {6, 6});
}

Evidence seen_from(const SceneBuilder& scene, const std::vector<Pose2>& poses) {
  EvidenceGrid grid;
  std::mt19937_64 random(1);
  for (const Pose2& pose : poses)
    grid.add(testing::simulate_scan(scene, kLidar, pose, random), pose);
  return grid.collect();
}

const Pose2 kLeft{3.0, 1.5, 0.0};
const Pose2 kRight{9.0, 4.5, 0.0};

TEST(NewGround, WhatWasSeenBeforeDecidesNothing) {
  const LocalizationMapPtr map = testing::make_map(two_rooms(), {3.0, 3.0});
  const Evidence accepted = seen_from(two_rooms(), {kLeft});
  EXPECT_EQ(NewGround(accepted).judge(map->index().classes, accepted, {}), Verdict::kUndecided);
}

TEST(NewGround, AgreesWhereTheMapExplainsTheNextRoom) {
  const LocalizationMapPtr map = testing::make_map(two_rooms(), {3.0, 3.0});
  const NewGround ground(seen_from(two_rooms(), {kLeft}));
  EXPECT_EQ(ground.judge(map->index().classes, seen_from(two_rooms(), {kLeft, kRight}), {}),
            Verdict::kAgrees);
}

TEST(NewGround, ContradictsWhereTheNextRoomIsAnother) {
  const LocalizationMapPtr map = testing::make_map(two_rooms(), {3.0, 3.0});
  const SceneBuilder other =
      SceneBuilder().room({0, 0}, {6, 6}).room({7.2, 1.3}, {10.1, 4.8}).wall({6, 0}, {6, 2.5});
  const NewGround ground(seen_from(other, {kLeft}));
  EXPECT_EQ(ground.judge(map->index().classes, seen_from(other, {kLeft, {8.6, 3.0, 0.0}}), {}),
            Verdict::kContradicts);
}

}  // namespace
}  // namespace cornerfix

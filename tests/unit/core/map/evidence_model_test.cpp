#include "core/src/map/evidence_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "support/drawn_grid.hpp"
#include "support/matchers.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::SceneBuilder;

using std::numbers::pi;
const Pose2 kT_map_grid{-1.025, -1.025, 0.0};

OccupancyGrid room_grid(double resolution = 0.05) {
  return testing::drawn_grid(testing::figure7_room(), {6.0, 5.0}, kT_map_grid, {12.0, 12.0},
                             resolution);
}

ClassField classes_of(const OccupancyGrid& grid) { return {grid, DistanceField(grid)}; }

/// What a robot sees at a pose of the room, in base_link.
Evidence evidence_at(const SceneBuilder& scene, const Pose2& T_map_laser, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  EvidenceGrid grid;
  grid.add(testing::simulate_scan(scene, {.beams = 720, .noise_m = 0.01}, T_map_laser, random), {});
  return grid.collect();
}

Evidence mirrored(Evidence evidence) {
  for (Point2& p : evidence.ends) p.y() = -p.y();
  for (Point2& p : evidence.free) p.y() = -p.y();
  return evidence;
}

Pose2 random_pose(std::mt19937_64& random) {
  std::uniform_real_distribution<double> x(4.0, 8.0), y(3.5, 7.0), yaw(-pi, pi);
  return {x(random), y(random), yaw(random)};
}

TEST(EvidenceModel, ExplainsNearlyAllAtTheTruePose) {
  const ClassField classes = classes_of(room_grid());
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::mt19937_64 random(seed);
    const Pose2 truth = random_pose(random);
    const EvidenceScore score =
        score_evidence(classes, evidence_at(testing::figure7_room(), truth, seed), truth);
    EXPECT_GT(score.log_likelihood, 0.0) << "seed " << seed;
    EXPECT_GT(score.matched, 0.95) << "seed " << seed;
    EXPECT_LT(score.contradicted, 0.02) << "seed " << seed;
    EXPECT_LT(score.end_counts[kHiddenNear] + score.end_counts[kHiddenFar], 0.05 * score.ends)
        << "seed " << seed;
  }
}

TEST(EvidenceModel, TheTruePoseBeatsShiftedAndTurnedOnes) {
  const ClassField classes = classes_of(room_grid());
  const Pose2 wrong[] = {{0.5, 0.0, 0.0},  {0.0, 0.5, 0.0},      {-1.0, 1.0, 0.0},
                         {0.0, 0.0, 0.15}, {0.0, 0.0, pi / 2.0}, {0.3, 0.0, pi}};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::mt19937_64 random(seed);
    const Pose2 truth = random_pose(random);
    const Evidence evidence = evidence_at(testing::figure7_room(), truth, seed);
    const double right = score_evidence(classes, evidence, truth).log_likelihood;
    for (const Pose2& off : wrong) {
      EXPECT_GT(right, score_evidence(classes, evidence, truth * off).log_likelihood + 20.0)
          << "seed " << seed << " off by " << ::testing::PrintToString(off);
    }
  }
}

TEST(EvidenceModel, TheTruePoseBeatsTheMirroredOnes) {
  const ClassField classes = classes_of(room_grid());
  const Pose2 truth{6.0, 5.0, 0.7};
  const Evidence evidence = evidence_at(testing::figure7_room(), truth);
  const double right = score_evidence(classes, evidence, truth).log_likelihood;
  const Evidence mirror_image = mirrored(evidence);
  for (int i = 0; i < 180; ++i) {
    const Pose2 turned{truth.x, truth.y, wrap_angle(i * pi / 90.0)};
    EXPECT_GT(right, score_evidence(classes, mirror_image, turned).log_likelihood + 20.0) << i;
  }
}

TEST(EvidenceModel, WhatLiesOutsideTheMapIsUnknownNotContradicted) {
  const ClassField classes = classes_of(room_grid());
  const Evidence evidence = evidence_at(testing::figure7_room(), {6.0, 5.0, 0.0});
  const EvidenceScore score = score_evidence(classes, evidence, {500.0, -500.0, 0.0});
  EXPECT_EQ(score.matched, 0.0);
  EXPECT_EQ(score.contradicted, 0.0);
  EXPECT_LT(score.log_likelihood, 0.0);
}

TEST(EvidenceModel, AnEndInKnownFreeSpaceWeighsMoreThanOneInUnknownSpace) {
  const ClassField classes = classes_of(room_grid());
  const auto weight_at = [&](const Point2& p) {
    return score_evidence(classes, {{p}, {}}, {}).log_likelihood;
  };
  const double on_wall = weight_at({10.0, 5.0});
  const double in_the_free = weight_at({6.0, 5.0});
  const double in_the_unknown = weight_at({10.7, 5.0});
  EXPECT_GT(on_wall, 0.0);
  EXPECT_LT(in_the_free, in_the_unknown);
  EXPECT_LT(in_the_unknown, 0.0);
  EXPECT_EQ(score_evidence(classes, {{{6.0, 5.0}}, {}}, {}).contradicted, 1.0);
}

TEST(EvidenceModel, APassedPlaceMustNotBeAWall) {
  const ClassField classes = classes_of(room_grid());
  const auto score_at = [&](const Point2& p) { return score_evidence(classes, {{}, {p}}, {}); };
  EXPECT_GT(score_at({6.0, 5.0}).log_likelihood, 0.0);
  EXPECT_LT(score_at({10.0, 5.0}).log_likelihood, 0.0);
}

TEST(EvidenceModel, AnEndBehindAWallIsHidden) {
  // A wall at x = 6 between the robot and the wall at x = 8 that it claims to have seen.
  const SceneBuilder scene = SceneBuilder().room({0, 0}, {8.0, 8.0}).wall({6, 0}, {6, 8});
  const ClassField classes =
      classes_of(testing::drawn_grid(scene, {2.0, 4.0}, {-1, -1, 0}, {10.0, 10.0}, 0.05));
  const auto is_hidden = [&](const Point2& from, const Point2& to) {
    const EvidenceScore score = score_evidence(classes, {.ends = {to}, .origins = {from}}, {});
    return score.end_counts[kHiddenNear] + score.end_counts[kHiddenFar] == 1;
  };
  EXPECT_TRUE(is_hidden({2.0, 4.0}, {7.98, 4.0}));
  EXPECT_TRUE(is_hidden({2.0, 4.0}, {7.0, 4.0})) << "beyond the wall, near none";
  EXPECT_FALSE(is_hidden({2.0, 4.0}, {5.98, 4.0})) << "on the wall itself";
  EXPECT_FALSE(is_hidden({2.0, 4.0}, {6.10, 4.0})) << "a noisy end";
  EXPECT_FALSE(is_hidden({2.0, 1.0}, {5.9, 7.0})) << "along the room";
  const EvidenceScore from_anywhere = score_evidence(classes, {.ends = {{7.98, 4.0}}}, {});
  EXPECT_EQ(from_anywhere.end_counts[kHiddenNear], 0);
}

TEST(EvidenceModel, ABeamThatGrazesAWallIsNotHidden) {
  const SceneBuilder scene = SceneBuilder().room({0, 0}, {20.0, 4.0});
  const ClassField classes =
      classes_of(testing::drawn_grid(scene, {2.0, 2.0}, {-1, -1, 0}, {22.0, 6.0}, 0.05));
  // Along the long wall, off by less than a pose may be.
  const Evidence evidence{.ends = {{19.98, -0.08}}, .origins = {{1.0, 0.1}}};
  const EvidenceScore score = score_evidence(classes, evidence, {});
  EXPECT_EQ(score.end_counts[kHiddenNear] + score.end_counts[kHiddenFar], 0);
}

TEST(EvidenceModel, ABeamPastTheEdgeOfAnObstacleIsNotHidden) {
  const SceneBuilder scene = SceneBuilder().room({0, 0}, {8.0, 8.0}).room({3, 3}, {4, 4});
  const ClassField classes =
      classes_of(testing::drawn_grid(scene, {2.0, 2.0}, {-1, -1, 0}, {10.0, 10.0}, 0.05));
  const auto hidden_hits = [&](double y) {
    const EvidenceScore score =
        score_evidence(classes, {.ends = {{7.98, y}}, .origins = {{1.0, y}}}, {});
    return score.end_counts[kHiddenNear] + score.end_counts[kHiddenFar];
  };
  EXPECT_EQ(hidden_hits(3.5), 1) << "through the middle";
  EXPECT_EQ(hidden_hits(3.05), 0) << "0.05 m inside its edge";
  EXPECT_EQ(hidden_hits(2.9), 0) << "past it";
}

TEST(EvidenceModel, NoEvidenceScoresNothing) {
  const EvidenceScore score = score_evidence(classes_of(room_grid()), {}, {6.0, 5.0, 0.0});
  EXPECT_EQ(score.log_likelihood, 0.0);
  EXPECT_EQ(score.ends, 0);
  EXPECT_EQ(score.matched, 0.0);
}

TEST(EvidenceModel, AnEmptyMapIsUnknownEverywhere) {
  const OccupancyGrid empty;
  const ClassField classes(empty, DistanceField(empty));
  const EvidenceScore score = score_evidence(classes, {{{0.0, 0.0}}, {{1.0, 0.0}}}, {});
  EXPECT_EQ(score.matched, 0.0);
  EXPECT_EQ(score.contradicted, 0.0);
}

TEST(EvidenceModel, ATurnedGridScoresTheSame) {
  const Pose2 truth{6.0, 5.0, 0.7};
  const Evidence evidence = evidence_at(testing::figure7_room(), truth);
  const double straight = score_evidence(classes_of(room_grid()), evidence, truth).log_likelihood;
  const Pose2 T_map_grid = Pose2{5.0, 5.0, pi} * Pose2{-6.025, -6.025, 0.0};
  const OccupancyGrid turned =
      testing::drawn_grid(testing::figure7_room(), {6.0, 5.0}, T_map_grid, {12.0, 12.0}, 0.05);
  EXPECT_NEAR(score_evidence(classes_of(turned), evidence, truth).log_likelihood, straight,
              0.1 * std::abs(straight));
}

TEST(EvidenceModel, TheLogLikelihoodIsSharedOutAmongTheBlocks) {
  const Pose2 truth{6.0, 5.0, 0.7};
  const Evidence evidence = evidence_at(testing::figure7_room(), truth);
  const EvidenceScore score = score_evidence(classes_of(room_grid()), evidence, truth);
  ASSERT_EQ(score.block_llr.size(), evidence.blocks);
  ASSERT_GT(evidence.blocks, 4U);
  double sum = 0.0;
  for (const float block : score.block_llr) sum += static_cast<double>(block);
  EXPECT_NEAR(sum, score.log_likelihood, 1e-3);
}

TEST(EvidenceModel, TheTruePoseExplainsItsHitsAndATurnedOneDoesNot) {
  const Pose2 truth{6.0, 5.0, 0.7};
  const Evidence evidence = evidence_at(testing::figure7_room(), truth);
  const ClassField classes = classes_of(room_grid());
  EXPECT_GT(explained_share(score_evidence(classes, evidence, truth)), 0.95);
  EXPECT_LT(explained_share(score_evidence(classes, evidence, truth * Pose2{0.0, 0.0, 0.5})), 0.6);
}

TEST(EvidenceModel, HitsInUnknownSpaceDoNotCountAsUnexplained) {
  const OccupancyGrid empty;
  const ClassField classes(empty, DistanceField(empty));
  EXPECT_EQ(explained_share(score_evidence(classes, {.ends = {{0.0, 0.0}}}, {})), 1.0);
}

}  // namespace
}  // namespace cornerfix

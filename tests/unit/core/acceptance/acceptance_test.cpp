#include "core/src/acceptance/acceptance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace cornerfix {
namespace {

constexpr double kOfficeArea = 1000.0;  // [m^2]

/// 200 hits over 40 blocks; the map explains a share of them.
EvidenceScore score_with(double explained, double independent_hits = 40.0) {
  EvidenceScore score;
  score.ends = 200;
  score.end_counts[0] = static_cast<int>(std::lround(200.0 * explained));
  score.end_counts[6] = 200 - score.end_counts[0];
  score.contradicted = 1.0 - explained;
  score.independent_hits = independent_hits;
  return score;
}

double probability(const EvidenceScore& best, double margin, std::vector<double> log_odds = {},
                   double area = kOfficeArea) {
  return weigh(best, margin, log_odds, area).probability_correct;
}

/// A pose and a rival that differ in blocks by `differences` [nat].
double log_odds_of(std::vector<float> differences) {
  EvidenceScore best;
  EvidenceScore rival;
  rival.block_llr.assign(differences.size(), 1.0F);
  for (const float difference : differences) best.block_llr.push_back(1.0F + difference);
  return rival_log_odds(best, rival);
}

TEST(Acceptance, APoseThatExplainsTheScansWithoutRivalsIsProbable) {
  EXPECT_GT(probability(score_with(0.95), 100.0), 0.99);
}

TEST(Acceptance, AMarginDoesNotExcuseAPoseThatExplainsLittle) {
  EXPECT_LT(probability(score_with(0.2), 150.0), 0.2);
  EXPECT_LT(probability(score_with(0.3), 150.0), 0.5);
}

TEST(Acceptance, FewIndependentHitsAreNotEnough) {
  EXPECT_LT(probability(score_with(1.0, 3.0), 150.0), 0.9);
  EvidenceScore one;
  one.ends = 1;
  one.end_counts[0] = 1;
  one.independent_hits = 1.0;
  EXPECT_LT(probability(one, 0.75), 0.5);
}

TEST(Acceptance, TheSameFitMeansLessInALargerMap) {
  const EvidenceScore score = score_with(0.8, 15.0);
  EXPECT_LT(chance_significance(score, 1e6), chance_significance(score, 1e3));
  EXPECT_LT(probability(score, 100.0, {}, 1e6), probability(score, 100.0, {}, 1e3));
}

TEST(Acceptance, ProbabilityGrowsWithTheOddsAgainstARival) {
  double last = 0.0;
  for (double log_odds = -2.0; log_odds <= 7.0; log_odds += 1.0) {
    const double p = probability(score_with(0.9), 30.0, {log_odds});
    EXPECT_GT(p, last) << log_odds;
    last = p;
  }
}

TEST(Acceptance, NoEvidenceGivesMoreThanTheCalibrationSupports) {
  EXPECT_LT(probability(score_with(1.0, 400.0), 150.0), 0.9995);
  EXPECT_EQ(probability(score_with(0.9), 30.0, {50.0}), probability(score_with(0.9), 30.0));
}

TEST(Acceptance, EvenOddsAreNoMoreThanOneHalf) {
  EXPECT_LE(probability(score_with(0.95), 100.0, {0.0}), 0.5);
}

TEST(Acceptance, ManyRivalsAreWorseThanOne) {
  const EvidenceScore score = score_with(0.9);
  EXPECT_LT(probability(score, 30.0, std::vector<double>(10, 6.0)),
            probability(score, 30.0, {6.0}));
}

TEST(Acceptance, WithoutMarginOrEvidenceNothingIsProbable) {
  EXPECT_EQ(probability(score_with(0.9), 0.0), 0.0);
  EXPECT_EQ(probability(score_with(0.9), -10.0), 0.0);
  EXPECT_EQ(probability({}, 100.0), 0.0);
}

TEST(RivalLogOdds, AreThoseOfASignTestWithAnUnknownRateOfChanges) {
  // P(q < 1/2) after n equal blocks for the best is 1 - 2^-(n + 1).
  for (const int n : {1, 4, 8})
    EXPECT_NEAR(log_odds_of(std::vector<float>(static_cast<std::size_t>(n), 2.0F)),
                std::log(std::exp2(n + 1) - 1.0), 1e-6);
}

TEST(RivalLogOdds, BlocksThatFavourTheRivalLowerThem) {
  const double agreeing = log_odds_of({2.0F, 2.0F, 2.0F, 2.0F, 2.0F, 2.0F});
  const double divided = log_odds_of({2.0F, 2.0F, 2.0F, 2.0F, -2.0F, -2.0F});
  EXPECT_LT(divided, 0.5 * agreeing);
  EXPECT_GT(divided, 0.0);
  EXPECT_NEAR(log_odds_of({2.0F, -2.0F}), 0.0, 1e-9);
}

TEST(RivalLogOdds, AChangedWarehouseIsNotDecidedByItsMargin) {
  // Stock that changed favours the rival in 20 blocks, and by chance the pose in 30.
  std::vector<float> differences(30, 8.0F);
  differences.insert(differences.end(), 20, -8.0F);
  const double margin = (30 - 20) * 8.0;
  EXPECT_LT(probability(score_with(0.9), margin, {log_odds_of(differences)}), 0.95);
}

TEST(RivalLogOdds, AreAntisymmetric) {
  EXPECT_NEAR(log_odds_of({3.0F, 1.0F, -1.0F}), -log_odds_of({-3.0F, -1.0F, 1.0F}), 1e-9);
}

TEST(RivalLogOdds, OneLargeDifferenceIsOneObservation) {
  EXPECT_NEAR(log_odds_of({100.0F, 0.0F, 0.0F}), std::log(3.0), 1e-6);
  EXPECT_GT(log_odds_of(std::vector<float>(20, 0.5F)), 10.0);
}

TEST(RivalLogOdds, AreZeroWithoutDifferences) {
  EXPECT_EQ(log_odds_of({}), 0.0);
  EXPECT_EQ(log_odds_of({0.0F, 0.0F}), 0.0);
}

/// A pose that matches each of `blocks` or not.
EvidenceScore matching(const std::vector<bool>& blocks) {
  EvidenceScore score;
  for (const bool is_matched : blocks) score.block_llr.push_back(is_matched ? 4.0F : -4.0F);
  return score;
}

TEST(RivalLogOdds, WhatOtherCopiesOfThePlaceMatchTooCountsLess) {
  // Doors: each copy of the place matches those that are in the same state by chance.
  const EvidenceScore best = matching({true, true, true, true, true, true, true, true});
  const EvidenceScore rival = matching({false, false, false, false, false, false, false, false});
  const EvidenceScore half = matching({true, false, true, false, true, false, true, false});
  const EvidenceScore other_half = matching({false, true, false, true, false, true, false, true});
  const std::vector<OtherPose> copies{{&rival, true}, {&half, true}, {&other_half, true}};
  const double alone = rival_log_odds(best, rival);
  const double among_copies = rival_log_odds(best, rival, copies);
  EXPECT_LT(among_copies, 0.85 * alone);
  // Each block is matched by one of three copies and counts 3/4.
  EXPECT_NEAR(among_copies, std::log(std::exp2(0.75 * 8.0 + 1.0) - 1.0), 1e-6);
}

TEST(RivalLogOdds, WhatHalfOfTheOtherPosesMatchIsLeftToTheSignTest) {
  const EvidenceScore best = matching({true, true, true, true});
  const EvidenceScore rival = matching({false, false, false, false});
  const EvidenceScore copy = matching({true, true, true, true});
  const EvidenceScore other = matching({false, false, false, false});
  // One of two matches each block: as probable as the sign test has it.
  const std::vector<OtherPose> turned{{&rival, false}, {&copy, false}, {&other, false}};
  EXPECT_NEAR(rival_log_odds(best, rival, turned), rival_log_odds(best, rival), 1e-9);
}

TEST(RivalLogOdds, WhatNoOtherPoseMatchesIsNoCoincidence) {
  const EvidenceScore best = matching({true, true, true, true});
  const EvidenceScore rival = matching({false, false, false, false});
  const EvidenceScore other = rival;
  const std::vector<OtherPose> others{{&rival, false}, {&other, false}, {&other, false}};
  // Four blocks, each with a coincidence of (0 + 1) / (2 + 2) instead of one half.
  EXPECT_NEAR(rival_log_odds(best, rival, others),
              rival_log_odds(best, rival) + 4.0 * std::log(2.0), 1e-9);
}

TEST(RivalLogOdds, BlocksThatFavourTheRivalMakeCoincidencesProbable) {
  const EvidenceScore best = matching({true, true, true, true, true, true, false, false});
  const EvidenceScore rival = matching({false, false, false, false, false, false, true, true});
  const EvidenceScore other = matching({false, false, false, false, false, false, false, false});
  const std::vector<OtherPose> others{{&rival, false}, {&other, false}};
  // Two coincidences happened: (0 + 2 + 1) / (1 + 2 + 2) is above one half.
  EXPECT_NEAR(rival_log_odds(best, rival, others), rival_log_odds(best, rival), 1e-9);
}

TEST(RivalLogOdds, APoseThatWasNotJudgedByBlocksMatchesNone) {
  const EvidenceScore best = matching({true, true, true, true});
  const EvidenceScore rival = matching({false, false, false, false});
  const EvidenceScore unmatched = rival;
  const EvidenceScore unjudged;
  const std::vector<OtherPose> without_blocks{{&rival, false}, {&unjudged, false}};
  const std::vector<OtherPose> with_blocks{{&rival, false}, {&unmatched, false}};
  EXPECT_EQ(rival_log_odds(best, rival, without_blocks), rival_log_odds(best, rival, with_blocks));
}

TEST(RivalLogOdds, AreFiniteForThousandsOfBlocks) {
  const double large = log_odds_of(std::vector<float>(3600, 1.0F));
  EXPECT_TRUE(std::isfinite(large));
  EXPECT_GT(large, 100.0);
}

}  // namespace
}  // namespace cornerfix

#include "core/src/acceptance/acceptance.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
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

double probability(const EvidenceScore& best, double margin, std::vector<double> rival_z = {},
                   double area = kOfficeArea) {
  return weigh(best, margin, rival_z, area).probability_correct;
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

TEST(Acceptance, ProbabilityGrowsWithTheMargin) {
  double last = probability(score_with(0.9), 0.0);
  for (double margin = 5.0; margin <= 150.0; margin += 5.0) {
    const double p = probability(score_with(0.9), margin, {1.0});
    EXPECT_GT(p, last) << margin;
    last = p;
  }
}

TEST(Acceptance, ManyRivalsAreWorseThanOne) {
  const EvidenceScore score = score_with(0.9);
  EXPECT_LT(probability(score, 30.0, std::vector<double>(10, 2.0)),
            probability(score, 30.0, {2.0}));
}

TEST(Acceptance, AMarginBeyondTheCalibrationDataAddsNothing) {
  const EvidenceScore score = score_with(0.9);
  EXPECT_EQ(probability(score, 0.75 * 200), probability(score, 5.0 * 200));
}

TEST(Acceptance, WithoutMarginOrEvidenceNothingIsProbable) {
  EXPECT_EQ(probability(score_with(0.9), 0.0), 0.0);
  EXPECT_EQ(probability(score_with(0.9), -10.0), 0.0);
  EXPECT_EQ(probability({}, 100.0), 0.0);
}

TEST(Acceptance, TheMarginForAProbabilityIsLargerForALargerOne) {
  const EvidenceScore score = score_with(0.9);
  EXPECT_LT(margin_for(score, kOfficeArea, 0.9), margin_for(score, kOfficeArea, 0.99));
}

TEST(Acceptance, NoMarginSufficesForAPoseThatExplainsLittle) {
  EXPECT_EQ(margin_for(score_with(0.2), kOfficeArea, 0.9), std::numeric_limits<double>::infinity());
}

TEST(MarginZ, IsTheSumOfBlocksInUnitsOfItsStandardError) {
  EvidenceScore best;
  EvidenceScore rival;
  best.block_llr = {1.0F, 1.0F, 1.0F, 1.0F};
  rival.block_llr = {0.0F, 0.0F, 0.0F, 0.0F};
  EXPECT_DOUBLE_EQ(margin_z(best, rival), 2.0);  // 4 / sqrt(4)
}

TEST(MarginZ, BlocksThatDisagreeLowerIt) {
  EvidenceScore best;
  EvidenceScore rival;
  best.block_llr = {5.0F, -4.0F, 5.0F, -4.0F};
  rival.block_llr = {0.0F, 0.0F, 0.0F, 0.0F};
  EXPECT_LT(margin_z(best, rival), 0.5);
  EXPECT_EQ(margin_z(best, best), 0.0);
}

}  // namespace
}  // namespace cornerfix

#include "evaluation/metrics/confidence_interval.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cornerfix::evaluation {
namespace {

TEST(ClopperPearson, AgreesWithPublishedIntervals) {
  // scipy.stats.binomtest(k, n).proportion_ci(0.95, method='exact')
  struct Case {
    std::size_t hits;
    std::size_t trials;
    double lower;
    double upper;
  };
  for (const Case& known :
       {Case{1, 10, 0.002528579, 0.445016117}, Case{24, 200, 0.078420248, 0.173272351},
        Case{282, 468, 0.556625429, 0.647198218}, Case{3, 10000, 0.000061871, 0.000876475}}) {
    const ConfidenceInterval interval = clopper_pearson(known.hits, known.trials);
    EXPECT_NEAR(interval.lower, known.lower, 1e-8) << known.hits << " of " << known.trials;
    EXPECT_NEAR(interval.upper, known.upper, 1e-8) << known.hits << " of " << known.trials;
  }
}

TEST(ClopperPearson, WithoutHitsReachesFromZeroToTheClosedForm) {
  for (const std::size_t trials : {1U, 40U, 10'000U}) {
    const ConfidenceInterval interval = clopper_pearson(0, trials);
    EXPECT_EQ(interval.lower, 0.0);
    EXPECT_NEAR(interval.upper, 1.0 - std::pow(0.025, 1.0 / static_cast<double>(trials)), 1e-9);
  }
}

TEST(ClopperPearson, OfMissesMirrorsThatOfHits) {
  const ConfidenceInterval hits = clopper_pearson(7, 50);
  const ConfidenceInterval misses = clopper_pearson(43, 50);
  EXPECT_NEAR(hits.lower, 1.0 - misses.upper, 1e-9);
  EXPECT_NEAR(hits.upper, 1.0 - misses.lower, 1e-9);
}

TEST(ClopperPearson, WithoutTrialsKnowsNothing) {
  const ConfidenceInterval interval = clopper_pearson(0, 0);
  EXPECT_EQ(interval.lower, 0.0);
  EXPECT_EQ(interval.upper, 1.0);
}

TEST(ClopperPearson, NarrowsAsTrialsGrowAndWidensWithConfidence) {
  const auto width = [](const ConfidenceInterval& i) { return i.upper - i.lower; };
  EXPECT_LT(width(clopper_pearson(50, 500)), width(clopper_pearson(10, 100)));
  EXPECT_GT(width(clopper_pearson(10, 100, 0.99)), width(clopper_pearson(10, 100)));
}

TEST(IncompleteBeta, HasItsClosedForms) {
  EXPECT_NEAR(incomplete_beta(1.0, 1.0, 0.3), 0.3, 1e-14);
  EXPECT_NEAR(incomplete_beta(3.0, 1.0, 0.5), 0.125, 1e-14);
  EXPECT_NEAR(incomplete_beta(1.0, 4.0, 0.25), 1.0 - std::pow(0.75, 4.0), 1e-14);
  EXPECT_NEAR(incomplete_beta(5000.0, 5000.0, 0.5), 0.5, 1e-10);
  EXPECT_EQ(incomplete_beta(2.0, 3.0, 0.0), 0.0);
  EXPECT_EQ(incomplete_beta(2.0, 3.0, 1.0), 1.0);
}

}  // namespace
}  // namespace cornerfix::evaluation

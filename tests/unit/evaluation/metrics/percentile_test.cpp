#include "evaluation/metrics/percentile.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cornerfix::evaluation {
namespace {

TEST(Percentile, IsTheValueBelowWhichTheShareLies) {
  EXPECT_EQ(percentile({4.0, 1.0, 3.0, 2.0}, 0.5), 3.0);
  EXPECT_EQ(percentile({3.0, 1.0, 2.0}, 0.5), 2.0);
  EXPECT_EQ(percentile({3.0, 1.0, 2.0}, 0.0), 1.0);
}

TEST(Percentile, OfTheWholeIsTheLargestValue) {
  EXPECT_EQ(percentile({3.0, 1.0, 2.0}, 1.0), 3.0);
  EXPECT_EQ(percentile({7.0}, 0.95), 7.0);
}

TEST(Percentile, IsNotANumberWithoutValues) {
  EXPECT_TRUE(std::isnan(percentile({}, 0.5)));
  EXPECT_TRUE(std::isnan(mean({})));
}

TEST(Percentile, MeanWeighsAllValuesTheSame) { EXPECT_DOUBLE_EQ(mean({1.0, 2.0, 6.0}), 3.0); }

TEST(Percentile, FiguresHaveFourDecimals) {
  EXPECT_DOUBLE_EQ(to_four_decimals(0.12345678), 0.1235);
  EXPECT_DOUBLE_EQ(to_four_decimals(-2.0), -2.0);
}

}  // namespace
}  // namespace cornerfix::evaluation

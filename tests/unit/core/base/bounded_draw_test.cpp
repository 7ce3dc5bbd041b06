#include "core/src/base/bounded_draw.hpp"

#include <gtest/gtest.h>

#include <array>

namespace cornerfix {
namespace {

TEST(BoundedDraw, GivesEveryNumberBelowTheBoundAboutAsOften) {
  std::mt19937_64 random(1);
  std::array<int, 6> counts{};
  for (int i = 0; i < 6'000; ++i) ++counts.at(bounded_draw(random, counts.size()));
  for (const int count : counts) EXPECT_NEAR(count, 1'000, 120);
}

TEST(BoundedDraw, IsZeroForABoundOfOne) {
  std::mt19937_64 random(1);
  EXPECT_EQ(bounded_draw(random, 1), 0U);
}

TEST(BoundedDraw, GivesTheSameNumbersForTheSameSeed) {
  std::mt19937_64 one(7);
  std::mt19937_64 other(7);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(bounded_draw(one, 1'000), bounded_draw(other, 1'000));
}

}  // namespace
}  // namespace cornerfix

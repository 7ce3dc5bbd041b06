#include "core/src/search/strip_sums.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace cornerfix {
namespace {

constexpr std::size_t kShift = 5;
constexpr std::uint8_t kWanted = 1;

/// Rows of values as small as those of a search: eight of them fit a byte.
class StripSumsOfRows : public ::testing::Test {
 protected:
  StripSumsOfRows() : rows_(3 * kGroup, std::vector<std::uint8_t>(kShift + kStrip)) {
    std::mt19937_64 random(4);
    for (auto& row : rows_) {
      for (std::uint8_t& value : row) value = static_cast<std::uint8_t>(random() % 32);
      sources_.push_back(row.data());
    }
    for (std::size_t i = 0; i < kStrip; ++i) {
      for (const auto& row : rows_) expected_[i] += row[kShift + i];
    }
  }

  std::vector<std::vector<std::uint8_t>> rows_;
  std::vector<const std::uint8_t*> sources_;
  std::array<int, kStrip> expected_{};
  std::vector<std::uint8_t> flags_ = std::vector<std::uint8_t>(kShift + kStrip, kWanted);
  std::size_t groups_ = 0;
  StripSums sums_{};
};

TEST_F(StripSumsOfRows, AreThoseOfAllSources) {
  const SumStep steps[] = {{sources_, 0}};
  ASSERT_TRUE(sum_strip(steps, flags_.data(), kWanted, kShift, sums_, groups_));
  for (std::size_t i = 0; i < kStrip; ++i) EXPECT_EQ(sums_[i], expected_[i]) << i;
}

TEST_F(StripSumsOfRows, AreTheSameInSeveralSteps) {
  const std::span<const std::uint8_t* const> all(sources_);
  const SumStep steps[] = {{all.first(kGroup), 1}, {all.subspan(kGroup), 2}};
  ASSERT_TRUE(sum_strip(steps, flags_.data(), kWanted, kShift, sums_, groups_));
  for (std::size_t i = 0; i < kStrip; ++i) EXPECT_EQ(sums_[i], expected_[i]) << i;
}

TEST_F(StripSumsOfRows, AreGivenUpWhenNoneReachesTheLeast) {
  const int highest = std::ranges::max(expected_);
  const SumStep reached[] = {{sources_, highest}};
  EXPECT_TRUE(sum_strip(reached, flags_.data(), kWanted, kShift, sums_, groups_));
  const SumStep missed[] = {{sources_, highest + 1}};
  EXPECT_FALSE(sum_strip(missed, flags_.data(), kWanted, kShift, sums_, groups_));
}

TEST_F(StripSumsOfRows, DoNotCountWhereTheFlagIsAnother) {
  const auto best =
      static_cast<std::size_t>(std::ranges::max_element(expected_) - expected_.begin());
  const SumStep steps[] = {{sources_, expected_[best]}};
  std::vector<std::uint8_t> only_best(kShift + kStrip, 0);
  only_best[kShift + best] = kWanted;
  EXPECT_TRUE(sum_strip(steps, only_best.data(), kWanted, kShift, sums_, groups_));
  const std::vector<std::uint8_t> none(kShift + kStrip, 0);
  EXPECT_FALSE(sum_strip(steps, none.data(), kWanted, kShift, sums_, groups_));
}

}  // namespace
}  // namespace cornerfix

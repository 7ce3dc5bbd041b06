#include "core/src/scan/longest_lines.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace cornerfix {
namespace {

/// Hits 0.2 m apart from `from` to `to`, with noise across them.
std::vector<Point2> wall(const Point2& from, const Point2& to) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.02);
  const double length = (to - from).norm();
  const Point2 along = (to - from) / length;
  std::vector<Point2> hits;
  for (double x = 0.0; x < length; x += 0.2)
    hits.emplace_back(from + x * along + noise(random) * Point2(-along.y(), along.x()));
  return hits;
}

std::vector<Point2> joined(const std::vector<std::vector<Point2>>& walls) {
  std::vector<Point2> hits;
  for (const std::vector<Point2>& one : walls) hits.insert(hits.end(), one.begin(), one.end());
  return hits;
}

const std::vector<Point2> kLong = wall({-3.0, 2.0}, {27.0, 9.0});
const std::vector<Point2> kMiddle = wall({4.0, -8.0}, {1.0, 6.0});
const std::vector<Point2> kShort = wall({10.0, -4.0}, {12.0, -5.0});
const std::vector<Point2> kHits = joined({kShort, kLong, kMiddle});

std::size_t count_on(const std::vector<bool>& are_on_lines, std::size_t from, std::size_t size) {
  const auto begin = are_on_lines.begin() + static_cast<std::ptrdiff_t>(from);
  return static_cast<std::size_t>(
      std::count(begin, begin + static_cast<std::ptrdiff_t>(size), true));
}

TEST(LongestLines, TheLongestWallIsTheFirstLine) {
  const std::vector<bool> are_on_line = are_on_longest_lines(kHits, 1);
  EXPECT_EQ(count_on(are_on_line, 0, kShort.size()), 0U);
  EXPECT_EQ(count_on(are_on_line, kShort.size(), kLong.size()), kLong.size());
  // Only where the walls cross.
  EXPECT_LT(count_on(are_on_line, kShort.size() + kLong.size(), kMiddle.size()), 4U);
}

TEST(LongestLines, TheNextLineIsThatOfTheOtherHits) {
  const std::vector<bool> are_on_lines = are_on_longest_lines(kHits, 2);
  EXPECT_EQ(count_on(are_on_lines, 0, kShort.size()), 0U);
  EXPECT_EQ(count_on(are_on_lines, kShort.size(), kLong.size() + kMiddle.size()),
            kLong.size() + kMiddle.size());
}

TEST(LongestLines, CollinearWallsAreOneLine) {
  const std::vector<Point2> hits =
      joined({wall({0.0, 3.0}, {5.0, 3.0}), wall({9.0, 3.0}, {14.0, 3.0})});
  EXPECT_EQ(count_on(are_on_longest_lines(hits, 1), 0, hits.size()), hits.size());
}

TEST(LongestLines, MoreLinesThanHitsTakeAllHits) {
  EXPECT_EQ(are_on_longest_lines(std::vector<Point2>{{1.0, 2.0}}, 3), std::vector<bool>{true});
  EXPECT_TRUE(are_on_longest_lines({}, 2).empty());
}

}  // namespace
}  // namespace cornerfix

#include "core/src/search/frontier.hpp"

#include <gtest/gtest.h>

namespace cornerfix {
namespace {

Node with_bound(int bound, int x = 0) { return {.bound = bound, .x = x}; }

TEST(Frontier, GivesTheHighestBoundFirst) {
  Frontier frontier(10);
  for (const int bound : {3, 9, 0, 7}) frontier.push(with_bound(bound));
  for (const int bound : {9, 7, 3, 0}) {
    ASSERT_EQ(frontier.top(), bound);
    EXPECT_EQ(frontier.pop().bound, bound);
  }
  EXPECT_EQ(frontier.top(), -1);
}

TEST(Frontier, GivesTheLatestOfEqualBoundsFirst) {
  Frontier frontier(10);
  frontier.push(with_bound(5, 1));
  frontier.push(with_bound(5, 2));
  EXPECT_EQ(frontier.pop().x, 2);
  EXPECT_EQ(frontier.pop().x, 1);
}

TEST(Frontier, ABetterBoundThatComesLaterIsNext) {
  Frontier frontier(10);
  frontier.push(with_bound(5));
  EXPECT_EQ(frontier.top(), 5);
  frontier.push(with_bound(8));
  EXPECT_EQ(frontier.pop().bound, 8);
  EXPECT_EQ(frontier.pop().bound, 5);
}

}  // namespace
}  // namespace cornerfix

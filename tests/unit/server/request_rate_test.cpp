#include "server/request_rate.hpp"

#include <gtest/gtest.h>

namespace cornerfix::server {
namespace {

using namespace std::chrono_literals;

const RequestRate::Clock::time_point kFirst{1000s};

TEST(RequestRate, TakesTheRequestsOfOneSecondAtOnceAndNoMore) {
  RequestRate rate(3);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(rate.must_wait("cart-7", kFirst));
  EXPECT_EQ(rate.must_wait("cart-7", kFirst), 1s);
}

TEST(RequestRate, RefillsEvenly) {
  RequestRate rate(10);
  for (int i = 0; i < 10; ++i) (void)rate.must_wait("cart-7", kFirst);
  EXPECT_FALSE(rate.must_wait("cart-7", kFirst + 150ms));
  EXPECT_TRUE(rate.must_wait("cart-7", kFirst + 150ms));
}

TEST(RequestRate, CountsCallersApart) {
  RequestRate rate(1);
  EXPECT_FALSE(rate.must_wait("cart-7", kFirst));
  EXPECT_FALSE(rate.must_wait("cart-8", kFirst));
  EXPECT_TRUE(rate.must_wait("cart-7", kFirst));
}

}  // namespace
}  // namespace cornerfix::server

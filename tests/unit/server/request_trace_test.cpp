#include "server/request_trace.hpp"

#include <gtest/gtest.h>

#include <string>

namespace cornerfix::server {
namespace {

TEST(RequestTrace, TakesRequestIdsThatAreSafeToRepeat) {
  EXPECT_TRUE(is_request_id("a"));
  EXPECT_TRUE(is_request_id("7f3c-2.B_x"));
  EXPECT_TRUE(is_request_id(std::string(128, 'a')));
  EXPECT_FALSE(is_request_id(""));
  EXPECT_FALSE(is_request_id(std::string(129, 'a')));
  EXPECT_FALSE(is_request_id("a b"));
  EXPECT_FALSE(is_request_id("a\r\nSet-Cookie: x"));
}

TEST(RequestTrace, KnowsATraceparent) {
  const std::string good = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";
  EXPECT_TRUE(is_traceparent(good));
  EXPECT_EQ(trace_id_of(good), "4bf92f3577b34da6a3ce929d0e0e4736");
  EXPECT_FALSE(is_traceparent("00-00000000000000000000000000000000-00f067aa0ba902b7-01"));
  EXPECT_FALSE(is_traceparent("01-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"));
  EXPECT_FALSE(is_traceparent("00-4BF92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"));
  EXPECT_EQ(trace_id_of("x"), "");
}

}  // namespace
}  // namespace cornerfix::server

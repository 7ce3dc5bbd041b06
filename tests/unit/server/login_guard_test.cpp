#include "server/login_guard.hpp"

#include <gtest/gtest.h>

#include <string>

namespace cornerfix::server {
namespace {

using namespace std::chrono_literals;

const LoginGuard::Clock::time_point kStart{1000s};
constexpr LoginLimits kThree{.wrong_tokens = 3, .window = 60s, .lockout = 30s};

TEST(LoginGuard, LocksAnAddressOutAfterManyWrongTokens) {
  LoginGuard guard(kThree);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(guard.note_wrong("10.0.0.1", std::to_string(i), kStart));
  EXPECT_FALSE(guard.must_wait("10.0.0.1", "right", kStart));
  EXPECT_TRUE(guard.note_wrong("10.0.0.1", "the fourth", kStart));
  EXPECT_EQ(guard.must_wait("10.0.0.1", "right", kStart + 10s), 20s);
  EXPECT_FALSE(guard.must_wait("10.0.0.1", "right", kStart + 30s));
}

TEST(LoginGuard, LocksNoOtherAddressOut) {
  LoginGuard guard(kThree);
  for (int i = 0; i < 4; ++i) (void)guard.note_wrong("10.0.0.1", std::to_string(i), kStart);
  EXPECT_FALSE(guard.must_wait("10.0.0.2", "right", kStart));
}

TEST(LoginGuard, CountsATokenThatIsTriedAgainAndAgainOnce) {
  LoginGuard guard(kThree);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(guard.note_wrong("10.0.0.1", "expired", kStart));
}

TEST(LoginGuard, ForgetsWrongTokensAfterTheWindow) {
  LoginGuard guard(kThree);
  for (int i = 0; i < 3; ++i) (void)guard.note_wrong("10.0.0.1", std::to_string(i), kStart);
  EXPECT_FALSE(guard.note_wrong("10.0.0.1", "the fourth", kStart + 60s));
}

TEST(LoginGuard, LetsTokensInThatWereAcceptedBeforeFromTheSameAddress) {
  LoginGuard guard(kThree);
  guard.note_accepted("10.0.0.1", "right");
  for (int i = 0; i < 4; ++i) (void)guard.note_wrong("10.0.0.1", std::to_string(i), kStart);
  EXPECT_FALSE(guard.must_wait("10.0.0.1", "right", kStart));
  EXPECT_TRUE(guard.must_wait("10.0.0.1", "another", kStart));
}

}  // namespace
}  // namespace cornerfix::server

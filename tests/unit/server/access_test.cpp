#include "server/access.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

constexpr const char* kNoon = "2024-05-01T12:00:00Z";

const TokenTable kTable({{"viewer-token-0123", Role::kViewer, "desk"},
                         {"robot-token-01234", Role::kRobot, "cart-7"}});

TEST(TokenTable, MakesEverybodyAnAdminWithoutTokens) {
  EXPECT_EQ(TokenTable({}).identify("", kNoon)->role, Role::kAdmin);
}

TEST(TokenTable, KnowsTheHolderOfAToken) {
  const auto holder = kTable.identify("Bearer robot-token-01234", kNoon);
  ASSERT_TRUE(holder);
  EXPECT_EQ(holder->role, Role::kRobot);
  EXPECT_EQ(holder->name, "cart-7");
}

TEST(TokenTable, IgnoresTheCaseOfTheScheme) {
  EXPECT_TRUE(kTable.identify("bearer robot-token-01234", kNoon));
}

TEST(TokenTable, RefusesWhatIsNotAKnownBearerToken) {
  for (const char* header :
       {"", "Bearer", "Bearer ", "Bearer robot-token-0123", "Bearer robot-token-012345",
        "Basic robot-token-01234", "robot-token-01234"}) {
    EXPECT_FALSE(kTable.identify(header, kNoon)) << header;
  }
}

TEST(TokenTable, KnowsStoredTokensUntilTheyExpire) {
  const TokenTable table({}, {{.name = "cart-7",
                               .role = "robot",
                               .maps = {"office"},
                               .hash = storage::hash_of_token("cfx_1"),
                               .expires = "2024-06-01T00:00:00Z"}});
  EXPECT_FALSE(table.is_empty());
  EXPECT_FALSE(table.identify("", kNoon));
  EXPECT_FALSE(table.identify("Bearer cfx_2", kNoon));
  const auto holder = table.identify("Bearer cfx_1", kNoon);
  ASSERT_TRUE(holder);
  EXPECT_EQ(holder->role, Role::kRobot);
  EXPECT_TRUE(holder->may_use("office"));
  EXPECT_FALSE(holder->may_use("lab"));
  EXPECT_FALSE(table.identify("Bearer cfx_1", "2024-06-01T00:00:00Z"));
}

TEST(Access, GivesEachRoleItsCalls) {
  EXPECT_TRUE(may(Role::kViewer, Access::kRead));
  EXPECT_FALSE(may(Role::kViewer, Access::kSession));
  EXPECT_TRUE(may(Role::kRobot, Access::kSession));
  EXPECT_FALSE(may(Role::kRobot, Access::kMap));
  EXPECT_TRUE(may(Role::kMapper, Access::kMap));
  EXPECT_FALSE(may(Role::kMapper, Access::kSession));
  EXPECT_TRUE(may(Role::kAdmin, Access::kMap));
  EXPECT_TRUE(may(Role::kAdmin, Access::kSession));
}

TEST(Principal, LetsARobotSeeItselfOnly) {
  const Principal robot{Role::kRobot, "cart-7"};
  EXPECT_TRUE(robot.may_see("cart-7"));
  EXPECT_FALSE(robot.may_see("cart-8"));
  EXPECT_TRUE((Principal{Role::kViewer, "desk"}.may_see("cart-8")));
}

}  // namespace
}  // namespace cornerfix::server

#include "server/access.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

const TokenTable kTable({{"viewer-token-0123", Role::kViewer, "desk"},
                         {"robot-token-01234", Role::kRobot, "cart-7"}});

TEST(TokenTable, MakesEverybodyAnAdminWithoutTokens) {
  EXPECT_EQ(TokenTable({}).identify("")->role, Role::kAdmin);
}

TEST(TokenTable, KnowsTheHolderOfAToken) {
  const auto holder = kTable.identify("Bearer robot-token-01234");
  ASSERT_TRUE(holder);
  EXPECT_EQ(holder->role, Role::kRobot);
  EXPECT_EQ(holder->name, "cart-7");
}

TEST(TokenTable, IgnoresTheCaseOfTheScheme) {
  EXPECT_TRUE(kTable.identify("bearer robot-token-01234"));
}

TEST(TokenTable, RefusesWhatIsNotAKnownBearerToken) {
  for (const char* header :
       {"", "Bearer", "Bearer ", "Bearer robot-token-0123", "Bearer robot-token-012345",
        "Basic robot-token-01234", "robot-token-01234"}) {
    EXPECT_FALSE(kTable.identify(header)) << header;
  }
}

TEST(Access, GivesEachRoleItsCalls) {
  EXPECT_TRUE(may(Role::kViewer, Access::kRead));
  EXPECT_FALSE(may(Role::kViewer, Access::kSession));
  EXPECT_TRUE(may(Role::kRobot, Access::kSession));
  EXPECT_FALSE(may(Role::kRobot, Access::kAdmin));
  EXPECT_TRUE(may(Role::kAdmin, Access::kAdmin));
}

TEST(Principal, LetsARobotSeeItselfOnly) {
  const Principal robot{Role::kRobot, "cart-7"};
  EXPECT_TRUE(robot.may_see("cart-7"));
  EXPECT_FALSE(robot.may_see("cart-8"));
  EXPECT_TRUE((Principal{Role::kViewer, "desk"}.may_see("cart-8")));
}

}  // namespace
}  // namespace cornerfix::server

#include "server/environment.hpp"

#include <gmock/gmock.h>

#include <array>

namespace cornerfix::server {
namespace {

using ::testing::ElementsAre;

TEST(Environment, GivesSettingsTheFileAndUnknownNames) {
  constexpr std::array<const char*, 7> kVariables = {"PATH=/bin",
                                                     "CORNERFIX_PORT=80",
                                                     "CORNERFIX_CONFIG=/etc/a.json",
                                                     "CORNERFIX_LISTEN=",
                                                     "CORNERFIX_PROT=81",
                                                     "PORT=82",
                                                     nullptr};
  const Environment environment = read_environment(kVariables.data());
  ASSERT_EQ(environment.overrides.size(), 1U);
  EXPECT_EQ(environment.overrides[0].key, "port");
  EXPECT_EQ(environment.overrides[0].text, "80");
  EXPECT_EQ(environment.overrides[0].source, "CORNERFIX_PORT");
  EXPECT_EQ(environment.config_file, "/etc/a.json");
  EXPECT_THAT(environment.unknown, ElementsAre("CORNERFIX_PROT"));
}

TEST(Environment, KeepsEqualSignsAndPassesOverTheTokenOfClients) {
  constexpr std::array<const char*, 5> kVariables = {
      "CORNERFIX_DATABASE=a=b.db", "CORNERFIX_TOKEN=a", "CORNERFIX_LISTEN", "=", nullptr};
  const Environment environment = read_environment(kVariables.data());
  ASSERT_EQ(environment.overrides.size(), 1U);
  EXPECT_EQ(environment.overrides[0].text, "a=b.db");
  EXPECT_THAT(environment.unknown, ElementsAre());
}

}  // namespace
}  // namespace cornerfix::server

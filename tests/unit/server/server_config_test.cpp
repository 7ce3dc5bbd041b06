#include "server/server_config.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "support/temporary_directory.hpp"

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;

ServerConfig valid_config() {
  ServerConfig config;
  config.database = "maps.db";
  return config;
}

TEST(ServerConfig, IsOverriddenByTheFileThenByVariablesThenByFlags) {
  const testing::TemporaryDirectory directory;
  std::ofstream(directory / "config.json")
      << R"({"database": "file.db", "port": 1, "max_scans": 7, "max_mappers": 8})";
  const auto config = load_config(directory / "config.json", {{"port", "2", "CORNERFIX_PORT"},
                                                              {"max_scans", "9", "CORNERFIX_…"},
                                                              {"port", "3", "--port"}});
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->database, "file.db");
  EXPECT_EQ(config->port, 3);
  EXPECT_EQ(config->request_limits.max_scans, 9U);
  EXPECT_EQ(config->max_mappers, 8U);
  EXPECT_EQ(config->request_limits.max_beams, 20'000U);
}

TEST(ServerConfig, NamesTheVariableOfASettingThatFitsNoOther) {
  const auto open = load_config(
      {}, {{"database", "a.db", "CORNERFIX_DATABASE"}, {"listen", "0.0.0.0", "CORNERFIX_LISTEN"}});
  ASSERT_FALSE(open);
  EXPECT_EQ(open.error().field, "CORNERFIX_LISTEN");
  const auto token =
      load_config({}, {{"database", "a.db", "CORNERFIX_DATABASE"},
                       {"tokens", R"([{"token": "a", "role": "admin"}])", "CORNERFIX_TOKENS"}});
  ASSERT_FALSE(token);
  EXPECT_EQ(token.error().field, "CORNERFIX_TOKENS/0/token");
}

TEST(ServerConfig, ReadsTokens) {
  const auto config = merge_json(
      valid_config(),
      R"({"tokens": [{"token": "0123456789abcdef", "role": "robot", "name": "cart-7"}]})");
  ASSERT_TRUE(config);
  ASSERT_EQ(config->tokens.size(), 1U);
  EXPECT_EQ(config->tokens[0].role, Role::kRobot);
  EXPECT_EQ(config->tokens[0].name, "cart-7");
}

TEST(ServerConfig, RefusesAnUnknownKey) {
  const auto config = merge_json({}, R"({"prot": 80})");
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().field, "/prot");
  EXPECT_THAT(config.error().message, HasSubstr("port"));
}

TEST(ServerConfig, NamesThePlaceWhereItIsNoJson) {
  const auto config = merge_json({}, "{\n  \"port\": 80,\n}");
  ASSERT_FALSE(config);
  EXPECT_THAT(config.error().message,
              HasSubstr("the configuration is not JSON: parse error at line 3, column 1"));
}

TEST(ServerConfig, RefusesAKeyThatIsThereTwice) {
  const auto config = merge_json({}, R"({"port": 80, "tokens": [], "port": 81})");
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().field, "/port");
  EXPECT_EQ(config.error().message, "is there twice, expected once");
}

TEST(ServerConfig, RefusesWrongValues) {
  for (const char* text :
       {R"({"port": "80"})", R"({"port": 65536})", R"({"port": -1})", R"({"port": 1.5})",
        R"({"max_scans": 0})", R"({"max_body_bytes": 18446744073709551615})", R"({"listen": 1})",
        R"({"allow_insecure_listen": 1})", R"({"drain_timeout_s": -1})", R"({"tokens": {}})",
        R"({"allowed_hosts": "a"})", R"({"allowed_hosts": [1]})", R"({"tokens": [1]})",
        R"({"tokens": [{"token": "0123456789abcdef"}]})",
        R"({"tokens": [{"token": "0123456789abcdef", "role": "king"}]})",
        R"({"tokens": [{"token": "0123456789abcdef", "role": "admin", "nmae": "x"}]})", "[]", "{",
        ""}) {
    EXPECT_FALSE(merge_json(valid_config(), text)) << text;
  }
}

TEST(ServerConfig, NeedsADatabase) { EXPECT_EQ(validate(ServerConfig{})->field, "/database"); }

TEST(ServerConfig, BindsToLoopbackOnlyWithoutTokens) {
  ServerConfig config = valid_config();
  for (const char* address : {"127.0.0.1", "127.8.8.8", "localhost", "::1"}) {
    config.listen = address;
    EXPECT_FALSE(validate(config)) << address;
  }
  for (const char* address : {"0.0.0.0", "::", "192.168.1.5", "12.7.0.1", ""}) {
    config.listen = address;
    EXPECT_EQ(validate(config)->field, "/listen") << address;
  }
}

TEST(ServerConfig, BindsAnywhereWithTokensOrWhenToldInSoManyWords) {
  ServerConfig config = valid_config();
  config.listen = "0.0.0.0";
  config.allow_insecure_listen = true;
  EXPECT_FALSE(validate(config));
  config.allow_insecure_listen = false;
  config.tokens = {{"0123456789abcdef", Role::kAdmin, "me"}};
  EXPECT_FALSE(validate(config));
}

TEST(ServerConfig, RefusesTokensThatAreEasyToGuessOrForNobody) {
  ServerConfig config = valid_config();
  config.tokens = {{"short", Role::kAdmin, "me"}};
  EXPECT_EQ(validate(config)->field, "/tokens/0/token");
  config.tokens = {{"0123456789abcdef", Role::kRobot, ""}};
  EXPECT_EQ(validate(config)->field, "/tokens/0/name");
}

TEST(ServerConfig, KnowsAFileThatOthersCanRead) {
  const testing::TemporaryDirectory directory;
  const std::filesystem::path file = directory / "config.json";
  std::ofstream(file) << "{}";
  using std::filesystem::perms;
  std::filesystem::permissions(file, perms::owner_read | perms::owner_write);
  EXPECT_FALSE(is_open_to_others(file));
  for (const perms open : {perms::group_read, perms::others_read, perms::others_write}) {
    std::filesystem::permissions(file, perms::owner_read | open);
    EXPECT_TRUE(is_open_to_others(file));
  }
  EXPECT_FALSE(is_open_to_others(directory / "none.json"));
}

TEST(ServerConfig, SaysWhichFileItCannotRead) {
  const testing::TemporaryDirectory directory;
  const auto config = load_config(directory / "none.json", {});
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(config.error().field, HasSubstr("none.json"));
}

}  // namespace
}  // namespace cornerfix::server

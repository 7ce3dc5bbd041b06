#include "server/settings.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;

std::string guide() {
  std::ifstream file(CORNERFIX_CONFIGURATION_GUIDE);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::optional<Error> put(ServerConfig& config, const char* key, const char* text) {
  return apply(config, {key, text, "the source"});
}

TEST(Settings, AreDocumentedWithVariableFlagAndDefault) {
  const std::string documented = guide();
  ASSERT_FALSE(settings().empty());
  for (const Setting& setting : settings()) {
    const std::string flag = setting.flag().empty() ? "–" : "`" + setting.flag() + "`";
    const std::string value =
        setting.default_value.empty() ? "–" : "`" + setting.default_value + "`";
    EXPECT_THAT(documented, HasSubstr("| `" + setting.key + "` | `" + setting.variable() + "` | " +
                                      flag + " | " + value + " |"));
  }
}

TEST(Settings, HaveDifferentKeys) {
  std::set<std::string> keys;
  for (const Setting& setting : settings()) EXPECT_TRUE(keys.insert(setting.key).second);
}

TEST(Settings, TakeTheirOwnDefaults) {
  for (const Setting& setting : settings()) {
    if (setting.default_value.empty()) continue;
    ServerConfig config;
    EXPECT_FALSE(apply(config, {setting.key, setting.default_value, "x"})) << setting.key;
  }
}

TEST(Settings, NameTheSourceOfAWrongValue) {
  for (const Setting& setting : settings()) {
    if (setting.kind == Setting::Kind::kText || setting.kind == Setting::Kind::kNames) continue;
    for (const char* text : {"x", "8080x", "-1", "1.5", "[1]", "\"1\"", "99999999999999999999"}) {
      ServerConfig config;
      const auto error = apply(config, {setting.key, text, setting.variable()});
      ASSERT_TRUE(error) << setting.key << " took " << text;
      EXPECT_EQ(error->field, setting.variable());
      EXPECT_THAT(error->message, HasSubstr("expected"));
    }
  }
}

TEST(Settings, AreReadFromTexts) {
  ServerConfig config;
  EXPECT_FALSE(put(config, "database", "8080"));
  EXPECT_FALSE(put(config, "port", "0"));
  EXPECT_FALSE(put(config, "max_beams", "12"));
  EXPECT_FALSE(put(config, "allow_insecure_listen", "true"));
  EXPECT_FALSE(put(config, "allowed_hosts", "maps.example.com,cart-7"));
  EXPECT_FALSE(put(config, "log_format", "json"));
  EXPECT_FALSE(put(config, "tokens", R"([{"token": "0123456789abcdef", "role": "mapper"}])"));
  EXPECT_EQ(config.database, "8080");
  EXPECT_EQ(config.port, 0);
  EXPECT_EQ(config.request_limits.max_beams, 12U);
  EXPECT_TRUE(config.allow_insecure_listen);
  EXPECT_THAT(config.allowed_hosts, ::testing::ElementsAre("maps.example.com", "cart-7"));
  EXPECT_EQ(config.log_format, LogFormat::kJson);
  ASSERT_EQ(config.tokens.size(), 1U);
  EXPECT_EQ(config.tokens[0].role, Role::kMapper);
}

TEST(Settings, RefuseALogFormatThatIsNone) {
  ServerConfig config;
  const auto error = put(config, "log_format", "xml");
  ASSERT_TRUE(error);
  EXPECT_THAT(error->message, HasSubstr("\"text\" or \"json\""));
}

TEST(Settings, OfTokensHaveNoFlag) {
  ASSERT_NE(find_setting("tokens"), nullptr);
  EXPECT_EQ(find_setting("tokens")->flag(), "");
  EXPECT_EQ(find_setting("tokens")->variable(), "CORNERFIX_TOKENS");
  EXPECT_EQ(find_setting("worker_threads")->flag(), "--worker-threads");
  EXPECT_EQ(find_setting("prot"), nullptr);
}

}  // namespace
}  // namespace cornerfix::server

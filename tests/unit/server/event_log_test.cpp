#include "server/event_log.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <string>

namespace cornerfix::server {
namespace {

TEST(EventLog, WritesJsonThatKeepsTextOfOthersInOneLine) {
  const std::string members = log_text(
      LogFormat::kJson, "request",
      {{"path", "/a\n\x1b[31m\"\xff"}, {"status", std::int64_t{404}}, {"ms", 1.5}, {"robot", ""}});
  EXPECT_EQ(members.find('\n'), std::string::npos);
  EXPECT_EQ(members.find('\x1b'), std::string::npos);
  const auto json = nlohmann::json::parse("{" + members + "}");
  EXPECT_EQ(json["event"], "request");
  EXPECT_EQ(json["status"], 404);
  EXPECT_EQ(json["ms"], 1.5);
  EXPECT_FALSE(json.contains("robot"));
}

TEST(EventLog, WritesTextForPeople) {
  EXPECT_EQ(log_text(LogFormat::kText, "lost", {{"session", "a\n"}, {"after_s", 2.0}}),
            "lost session=a\\x0a after_s=2.000");
}

}  // namespace
}  // namespace cornerfix::server

#include "clients/cpp/curl.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "support/temporary_directory.hpp"

namespace cornerfix::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  for (int character = std::fgetc(pipe); character != EOF; character = std::fgetc(pipe)) {
    output += static_cast<char>(character);
  }
  pclose(pipe);
  return output;
}

/// The words of a command line as a real shell takes them apart, with a stand-in for curl.
std::vector<std::string> words(const std::string& line) {
  std::istringstream output(output_of("curl() { printf '%s\\001' \"$@\"; }; SESSION=s-1; " + line));
  std::vector<std::string> out;
  for (std::string word; std::getline(output, word, '\001');) out.push_back(word);
  return out;
}

class CurlLines : public ::testing::Test {
 protected:
  std::string line(const HttpRequest& request, const std::string& token = "",
                   const std::string& url = "http://127.0.0.1:8080") {
    CurlWriter writer({url, token}, directory_.path() / "bodies");
    const Result<std::string> line = writer.line(request);
    EXPECT_TRUE(line.ok());
    return line.ok() ? *line : "";
  }
  testing::TemporaryDirectory directory_;
};

TEST_F(CurlLines, GetsWithoutABody) {
  EXPECT_THAT(words(line({"GET", "/v1/maps?limit=3&page_token=a%20b"})),
              ElementsAre("-sS", "--fail-with-body",
                          "http://127.0.0.1:8080/v1/maps?limit=3&page_token=a%20b"));
}

TEST_F(CurlLines, SendsJsonWithItsContentType) {
  const std::string body = R"({"description": "it's $HOME `ls` \"here\" \\ !"})"
                           "\n";
  EXPECT_THAT(words(line({"PUT", "/v1/maps/a", body})),
              ElementsAre("-sS", "--fail-with-body", "-X", "PUT", "http://127.0.0.1:8080/v1/maps/a",
                          "-H", "Content-Type: application/json", "--data-binary", body));
}

TEST_F(CurlLines, PutsALargeBodyIntoAFile) {
  const std::string body = '"' + std::string(CurlWriter::kMaxInlineBytes, 'x') + '"';
  const auto parts = words(line({"POST", "/v1/maps/a/scans", body}));
  ASSERT_THAT(parts.back(), StartsWith("@"));
  std::ifstream file(parts.back().substr(1));
  std::stringstream content;
  content << file.rdbuf();
  EXPECT_EQ(content.str(), body);
}

TEST_F(CurlLines, ShowTheToken) {
  EXPECT_THAT(
      words(line({"DELETE", "/v1/maps/a"}, "se'cret")),
      ElementsAre("-sS", "--fail-with-body", "-X", "DELETE", "http://127.0.0.1:8080/v1/maps/a",
                  "-H", "Authorization: Bearer se'cret"));
}

TEST_F(CurlLines, GiveAPostWithoutABodyALength) {
  EXPECT_THAT(words(line({"POST", "/v1/sessions/7/reset"})), ::testing::Contains("-d"));
}

TEST_F(CurlLines, LeaveTheSessionToTheShell) {
  EXPECT_THAT(words(line({"DELETE", "/v1/sessions/$SESSION"})).back(),
              "http://127.0.0.1:8080/v1/sessions/s-1");
}

TEST_F(CurlLines, KeepTheIdOfACreatedSession) {
  const std::string create = line({"POST", "/v1/sessions", "{}", true});
  EXPECT_EQ(
      output_of("curl() { printf '%s' '{\"robot\": \"r\", \"id\": \"abc-1\", \"n\": 1}'; }; " +
                create + "; printf '%s' \"$SESSION\""),
      "abc-1");
}

TEST_F(CurlLines, TakeAServerBehindAPath) {
  EXPECT_THAT(line({"GET", "/v1/maps"}, "", "http://host/robots/"),
              HasSubstr("'http://host/robots/v1/maps'"));
}

TEST(PercentEncode, LeavesNamesAndHidesAllElse) {
  EXPECT_EQ(percent_encode("Office-2.a_b"), "Office-2.a_b");
  EXPECT_EQ(percent_encode("a/b c?%\xc3\xa9"), "a%2Fb%20c%3F%25%C3%A9");
}

}  // namespace
}  // namespace cornerfix::client

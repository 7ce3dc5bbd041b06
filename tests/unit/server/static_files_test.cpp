#include "server/static_files.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "support/temporary_directory.hpp"

namespace cornerfix::server {
namespace {

class StaticFilesTest : public ::testing::Test {
 protected:
  StaticFilesTest() {
    std::filesystem::create_directories(directory_ / "web/sub");
    std::filesystem::create_directories(directory_ / "leaflet");
    write("web/index.html", "<html>");
    write("web/app.js", "let a;");
    write("web/.hidden", "no");
    write("secret", "no");
    write("leaflet/leaflet.css", "p {}");
    files_.mount("", directory_ / "web");
    files_.mount("vendor/leaflet", directory_ / "leaflet");
  }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(directory_ / name) << text;
  }
  std::optional<Response> get(const std::string& target, const std::string& if_none_match = "") {
    return files_.get(split_path(target).value(), if_none_match);
  }

  testing::TemporaryDirectory directory_;
  StaticFiles files_;
};

TEST_F(StaticFilesTest, ServesTheIndexAtTheRoot) {
  const auto response = get("/");
  ASSERT_TRUE(response);
  EXPECT_EQ(response->body, "<html>");
  EXPECT_EQ(response->content_type, "text/html; charset=utf-8");
}

TEST_F(StaticFilesTest, ServesAMountedDirectory) {
  EXPECT_EQ(get("/vendor/leaflet/leaflet.css")->content_type, "text/css; charset=utf-8");
}

TEST_F(StaticFilesTest, KnowsWhatTheClientHas) {
  const auto first = get("/app.js");
  ASSERT_EQ(first->headers[0].first, "ETag");
  const auto second = get("/app.js", first->headers[0].second);
  EXPECT_EQ(second->status, 304);
  EXPECT_TRUE(second->body.empty());
  write("web/app.js", "let other;");
  EXPECT_EQ(get("/app.js", first->headers[0].second)->status, 200);
}

TEST_F(StaticFilesTest, NeverLeavesItsDirectories) {
  for (const char* target :
       {"/../secret", "/%2e%2e/secret", "/..%2fsecret", "/sub/../../secret", "/.hidden", "/sub",
        "/sub/", "/none.js", "/app.js/", "/app.js%00", "//app.js", "/vendor/leaflet"}) {
    EXPECT_FALSE(get(target)) << target;
  }
}

}  // namespace
}  // namespace cornerfix::server

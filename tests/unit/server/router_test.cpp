#include "server/router.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

using ::testing::ElementsAre;

Router sample_router() {
  Router router;
  for (const auto& [method, pattern] :
       std::vector<std::pair<const char*, const char*>>{{"GET", "/v1/maps"},
                                                        {"GET", "/v1/maps/{map}"},
                                                        {"PUT", "/v1/maps/{map}"},
                                                        {"POST", "/v1/maps/{map}/scans"}}) {
    router.add({.method = method, .pattern = pattern, .handler = {}});
  }
  return router;
}

const Router kRouter = sample_router();

std::variant<RouteMatch, MethodNotAllowed, NoRoute> match(const char* method, const char* target) {
  return kRouter.match(method, split_path(target).value());
}

TEST(SplitPath, DecodesEachSegmentOnce) {
  EXPECT_THAT(*split_path("/v1/a%20b/%2541?x=/y"), ElementsAre("v1", "a b", "%41"));
}

TEST(SplitPath, KeepsAnEscapedSlashInItsSegment) {
  EXPECT_THAT(*split_path("/v1/a%2Fb"), ElementsAre("v1", "a/b"));
}

TEST(SplitPath, TakesTheAbsoluteForm) {
  EXPECT_THAT(*split_path("http://host:80/v1/maps"), ElementsAre("v1", "maps"));
  EXPECT_THAT(*split_path("http://host"), ElementsAre(""));
}

TEST(SplitPath, SeesATrailingSlash) { EXPECT_THAT(*split_path("/v1/"), ElementsAre("v1", "")); }

TEST(SplitPath, RefusesBrokenEscapesAndWhatIsNoPath) {
  for (const char* target : {"/%", "/%4", "/%zz", "/%-1", "*", ""}) {
    EXPECT_EQ(split_path(target), std::nullopt) << target;
  }
}

TEST(Router, FindsARouteWithItsCaptures) {
  const auto found = std::get<RouteMatch>(match("POST", "/v1/maps/office/scans"));
  EXPECT_EQ(found.route->pattern, "/v1/maps/{map}/scans");
  EXPECT_THAT(found.captures, ElementsAre("office"));
}

TEST(Router, ServesHeadByGet) {
  EXPECT_EQ(std::get<RouteMatch>(match("HEAD", "/v1/maps")).route->method, "GET");
}

TEST(Router, TellsWhatAKnownPathTakes) {
  EXPECT_EQ(std::get<MethodNotAllowed>(match("PATCH", "/v1/maps/office")).allow, "GET, HEAD, PUT");
}

TEST(Router, KnowsNoOtherPath) {
  for (const char* target : {"/", "/v1", "/v1/maps/", "/v1/maps//scans", "/v1/maps/office/",
                             "/v1/maps/office/scans/", "/V1/maps", "/v1/maps/office/scan"}) {
    EXPECT_TRUE(std::holds_alternative<NoRoute>(match("GET", target))) << target;
  }
}

TEST(CheckQuery, NamesAnUnknownParameterAndThoseThatAreTaken) {
  const Route route{
      .method = "GET", .pattern = "/v1/maps", .handler = {}, .parameters = {"limit", "page_token"}};
  EXPECT_FALSE(check_query(route, {}));
  EXPECT_FALSE(check_query(route, {{"limit", "3"}, {"page_token", ""}}));
  const auto problem = check_query(route, {{"limit", "3"}, {"lmit", "4"}});
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->status, 422);
  ASSERT_EQ(problem->errors.size(), 1U);
  EXPECT_EQ(problem->errors[0].pointer, "/lmit");
  EXPECT_EQ(problem->errors[0].detail, "unknown query parameter, expected limit, page_token");
}

TEST(CheckQuery, RefusesAParameterThatIsThereTwice) {
  const Route route{.method = "GET", .pattern = "/v1/maps", .handler = {}, .parameters = {"limit"}};
  EXPECT_EQ(check_query(route, {{"limit", "3"}, {"limit", "4"}})->errors[0].detail,
            "is there twice");
}

TEST(ParseQuery, DecodesNamesAndValues) {
  const auto query = parse_query("/v1/maps?page_token=a%2Bb+c&li%6Dit=&&x&y=1=2#z=3");
  const std::multimap<std::string, std::string> expected{
      {"page_token", "a+b c"}, {"limit", ""}, {"x", ""}, {"y", "1=2"}};
  EXPECT_EQ(query, expected);
  EXPECT_TRUE(parse_query("/v1/maps").empty());
  EXPECT_TRUE(parse_query("/v1/maps?").empty());
  EXPECT_EQ(parse_query("/?a=%zz+").find("a")->second, "%zz+");
}

TEST(ParseQuery, KeepsAParameterThatIsThereTwiceWithOneValue) {
  const Route route{.method = "GET", .pattern = "/v1/maps", .handler = {}, .parameters = {"limit"}};
  EXPECT_EQ(check_query(route, parse_query("/v1/maps?limit=3&limit=3"))->errors[0].detail,
            "is there twice");
}

TEST(CheckQuery, RefusesAnyParameterWhereNoneIsTaken) {
  EXPECT_EQ(check_query(Route{}, {{"x", ""}})->errors[0].detail,
            "unknown query parameter, expected none");
}

}  // namespace
}  // namespace cornerfix::server

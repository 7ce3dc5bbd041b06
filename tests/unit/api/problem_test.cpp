#include "api/problem.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace cornerfix::api {
namespace {

TEST(Problem, HasTheStatusOfItsErrorCode) {
  EXPECT_EQ(http_status(ErrorCode::kMalformed), 400);
  EXPECT_EQ(http_status(ErrorCode::kNotFound), 404);
  EXPECT_EQ(http_status(ErrorCode::kConflict), 409);
  EXPECT_EQ(http_status(ErrorCode::kTooLarge), 413);
  EXPECT_EQ(http_status(ErrorCode::kInvalidArgument), 422);
  EXPECT_EQ(http_status(ErrorCode::kInternal), 500);
  EXPECT_EQ(http_status(ErrorCode::kCorruptData), 500);
  EXPECT_EQ(http_status(ErrorCode::kUnavailable), 503);
  EXPECT_EQ(http_status(ErrorCode::kStorageFull), 507);
}

TEST(Problem, RendersTheMembersOfRfc9457) {
  Problem problem = make_problem(ErrorCode::kInvalidArgument, "one thing");
  problem.errors.push_back({"/scans/3/ranges/17", "must be a number"});
  EXPECT_EQ(nlohmann::json::parse(render(problem)), nlohmann::json::parse(R"({
              "type": "urn:cornerfix:problem:invalid_argument", "title": "Well-formed but wrong",
              "status": 422, "code": "invalid_argument", "detail": "one thing",
              "errors": [{"pointer": "/scans/3/ranges/17", "detail": "must be a number"}]})"));
}

TEST(Problem, LeavesErrorsOutWhenThereAreNone) {
  const auto body = nlohmann::json::parse(render(make_problem(ErrorCode::kNotFound, "no map")));
  EXPECT_FALSE(body.contains("errors"));
}

TEST(Problem, StatesWhereASessionIsForABatchOfAnotherSequence) {
  Problem problem = make_problem(ErrorCode::kConflict, "ahead");
  EXPECT_FALSE(nlohmann::json::parse(render(problem)).contains("expected"));
  problem.conflict = {.expected = 3, .last_stamp = 12.5};
  EXPECT_EQ(nlohmann::json::parse(render(problem)).at("expected"), 3);
  EXPECT_EQ(nlohmann::json::parse(render(problem)).at("last_stamp"), 12.5);
  problem.conflict = {.expected = 0, .last_stamp = std::nullopt};
  EXPECT_TRUE(nlohmann::json::parse(render(problem)).at("last_stamp").is_null());
}

TEST(Problem, ReplacesBytesThatAreNotUtf8) {
  const auto body =
      nlohmann::json::parse(render(make_problem(ErrorCode::kNotFound, "map \xff\xfe")));
  EXPECT_EQ(body.at("detail"), "map \xEF\xBF\xBD\xEF\xBF\xBD");
}

TEST(Problem, KeepsInternalDetailsToTheLog) {
  for (const ErrorCode code : {ErrorCode::kInternal, ErrorCode::kCorruptData}) {
    const std::string body = render(to_problem({code, "open secret.db failed", "secret.db"}));
    EXPECT_EQ(body.find("secret"), std::string::npos) << body;
  }
}

TEST(Problem, PointsAtTheWrongParameter) {
  const Problem problem =
      to_problem({ErrorCode::kInvalidArgument, "must be positive", "grid.resolution_m"});
  ASSERT_EQ(problem.errors.size(), 1U);
  EXPECT_EQ(problem.errors[0].pointer, "/grid/resolution_m");
}

TEST(FieldErrors, ListsTheFirstTwentyAndCountsAll) {
  FieldErrors errors;
  for (int i = 0; i < 23; ++i) errors.add("/scans/" + std::to_string(i), "must be an object");
  const Problem problem = std::move(errors).to_problem();
  EXPECT_EQ(problem.status, 422);
  EXPECT_EQ(problem.errors.size(), 20U);
  EXPECT_EQ(problem.errors.back().pointer, "/scans/19");
  EXPECT_THAT(problem.detail, ::testing::HasSubstr("23 members"));
}

TEST(FieldErrors, PutsASingleErrorIntoTheDetail) {
  FieldErrors errors;
  errors.add("/robot", "is needed: the robot's name");
  EXPECT_EQ(std::move(errors).to_problem().detail, "/robot: is needed: the robot's name");
}

}  // namespace
}  // namespace cornerfix::api

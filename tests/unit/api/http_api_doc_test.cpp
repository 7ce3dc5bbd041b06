// docs/http-api.md describes every call, and its answers are documents of the API.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "api/openapi.hpp"
#include "unit/api/schema_check.hpp"

namespace cornerfix::api {
namespace {

std::string guide() {
  std::ifstream file(CORNERFIX_HTTP_API_GUIDE);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<nlohmann::json> answers_in(const std::string& text) {
  constexpr std::string_view kOpen = "```json\n";
  std::vector<nlohmann::json> answers;
  for (auto at = text.find(kOpen); at != std::string::npos; at = text.find(kOpen, at)) {
    at += kOpen.size();
    answers.push_back(nlohmann::json::parse(text.substr(at, text.find("```", at) - at)));
  }
  return answers;
}

/// By a member that only documents of this kind have.
std::string schema_of(const nlohmann::json& answer) {
  for (const auto& [member, schema] : std::vector<std::pair<const char*, const char*>>{
           {"jobs", "JobList"},
           {"cancelling", "Job"},
           {"type", "Problem"},
           {"agvPosition", "Vda5050State"},
           {"warnings", "FloorMapResult"},
           {"digest", "Map"},
           {"summary", "Report"},
           {"progress", "ReportProgress"},
           {"maps", answer.contains("robot") ? "Session" : "MapList"},
           {"accepted", "MapBatch"},
           {"entries", "Descriptor"},
           {"answers", "SessionHistory"},
           {"timing_ms", "Answer"},
           {"features", "FeatureList"}}) {
    if (answer.contains(member)) return schema;
  }
  return "";
}

TEST(HttpApiGuide, TellsEveryPath) {
  const std::string text = guide();
  const auto openapi = nlohmann::json::parse(openapi_json());
  for (const auto& [path, item] : openapi.at("paths").items()) {
    EXPECT_NE(text.find(path), std::string::npos) << path;
  }
}

TEST(HttpApiGuide, ShowsAnswersThatFitTheirSchemas) {
  const auto openapi = nlohmann::json::parse(openapi_json());
  const SchemaCheck schemas(openapi, true);
  const auto answers = answers_in(guide());
  EXPECT_GE(answers.size(), 10U);
  for (const nlohmann::json& answer : answers) {
    const std::string schema = schema_of(answer);
    ASSERT_FALSE(schema.empty()) << answer;
    EXPECT_THAT(schemas.check({{"$ref", "#/components/schemas/" + schema}}, answer),
                ::testing::IsEmpty())
        << answer;
  }
}

}  // namespace
}  // namespace cornerfix::api

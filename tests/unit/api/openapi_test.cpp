#include "api/openapi.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "api/answer_profiles.hpp"
#include "api/json_codec.hpp"
#include "api/params_codec.hpp"
#include "api/problem.hpp"
#include "unit/api/schema_check.hpp"

namespace cornerfix::api {
namespace {

using ::testing::IsEmpty;

const nlohmann::json& openapi() {
  static const auto document = nlohmann::json::parse(openapi_json());
  return document;
}

/// `visit` gets "PUT /v1/maps/{map}" and the operation.
void for_each_operation(
    const std::function<void(const std::string&, const nlohmann::json&)>& visit) {
  static const std::set<std::string> methods{"get", "put", "post", "delete"};
  for (const auto& [path, item] : openapi().at("paths").items()) {
    for (const auto& [method, operation] : item.items()) {
      if (methods.contains(method)) visit(method + " " + path, operation);
    }
  }
}

const nlohmann::json& resolved(const nlohmann::json& node) {
  if (!node.contains("$ref")) return node;
  return openapi().at(nlohmann::json::json_pointer(node["$ref"].get<std::string>().substr(1)));
}

nlohmann::json schema_named(const std::string& name) {
  return {{"$ref", "#/components/schemas/" + name}};
}

/// What does not fit the schema of that name, undocumented members too.
std::vector<std::string> misfits(const std::string& name, const Json& document) {
  return SchemaCheck(openapi(), true)
      .check(schema_named(name), nlohmann::json::parse(document.dump()));
}

void for_each_node(const nlohmann::json& node,
                   const std::function<void(const nlohmann::json&)>& visit) {
  visit(node);
  if (!node.is_structured()) return;
  for (const auto& child : node) for_each_node(child, visit);
}

TEST(Openapi, KeepsTheTypesOfYamlScalars) {
  EXPECT_EQ(openapi().at("openapi"), "3.1.0");
  EXPECT_EQ(openapi().at("info").at("version"), "0.1.0");
  const auto& options = openapi().at("components").at("schemas").at("Options");
  EXPECT_EQ(options.at("additionalProperties"), false);
  EXPECT_EQ(options.at("properties").at("min_votes").at("minimum"), 1);
  EXPECT_TRUE(openapi().at("paths").at("/healthz").at("get").at("responses").contains("200"));
}

TEST(Openapi, HasEveryReferenceInIt) {
  int references = 0;
  for_each_node(openapi(), [&](const nlohmann::json& node) {
    if (!node.is_object() || !node.contains("$ref")) return;
    const std::string reference = node["$ref"];
    ++references;
    ASSERT_EQ(reference.substr(0, 2), "#/");
    EXPECT_TRUE(openapi().contains(nlohmann::json::json_pointer(reference.substr(1)))) << reference;
  });
  EXPECT_GT(references, 100);
}

TEST(Openapi, NamesEveryOperationOnce) {
  std::set<std::string> names;
  for_each_operation([&](const std::string& where, const nlohmann::json& operation) {
    EXPECT_TRUE(operation.contains("summary")) << where;
    EXPECT_TRUE(operation.contains("tags")) << where;
    ASSERT_TRUE(operation.contains("operationId")) << where;
    EXPECT_TRUE(names.insert(operation["operationId"]).second) << where;
  });
}

TEST(Openapi, HasEveryCallOfTheContract) {
  std::set<std::string> calls;
  for_each_operation(
      [&](const std::string& where, const nlohmann::json& /*operation*/) { calls.insert(where); });
  EXPECT_EQ(calls, (std::set<std::string>{
                       "get /v1/maps",
                       "put /v1/maps/{map}",
                       "get /v1/maps/{map}",
                       "delete /v1/maps/{map}",
                       "post /v1/maps/{map}/scans",
                       "put /v1/maps/{map}/trajectory",
                       "put /v1/maps/{map}/grid",
                       "get /v1/maps/{map}/revisions",
                       "post /v1/maps/{map}/rollback",
                       "get /v1/maps/{map}/archive",
                       "post /v1/maps/{map}/archive",
                       "get /v1/maps/{map}/features",
                       "get /v1/maps/{map}/features/{id}/descriptor",
                       "get /v1/maps/{map}/grid.png",
                       "get /v1/maps/{map}/grid.yaml",
                       "get /v1/maps/{map}/report",
                       "get /v1/maps/{map}/report.svg",
                       "post /v1/maps/{map}/localize",
                       "get /v1/sessions",
                       "post /v1/sessions",
                       "get /v1/sessions/{session}",
                       "delete /v1/sessions/{session}",
                       "post /v1/sessions/{session}/reset",
                       "post /v1/sessions/{session}/scans",
                       "get /v1/sessions/{session}/events",
                       "get /v1/sessions/{session}/history",
                       "get /v1/jobs",
                       "get /v1/jobs/{job}",
                       "get /v1/jobs/{job}/result",
                       "delete /v1/jobs/{job}",
                       "get /healthz",
                       "get /readyz",
                       "get /metrics",
                       "get /openapi.json",
                   }));
}

TEST(Openapi, AnswersEveryErrorWithAProblem) {
  for_each_operation([&](const std::string& where, const nlohmann::json& operation) {
    int successes = 0;
    for (const auto& [status, response] : operation.at("responses").items()) {
      const int code = std::stoi(status);
      if (code < 400) {
        ++successes;
        continue;
      }
      const auto& content = resolved(response).at("content");
      EXPECT_TRUE(content.contains("application/problem+json")) << where << " " << status;
    }
    EXPECT_GT(successes, 0) << where;
  });
}

TEST(Openapi, TellsWhatABodyMayGetWrong) {
  for_each_operation([&](const std::string& where, const nlohmann::json& operation) {
    if (!operation.contains("requestBody")) return;
    for (const char* status : {"400", "411", "413", "415", "422"}) {
      EXPECT_TRUE(operation.at("responses").contains(status)) << where << " " << status;
    }
  });
}

TEST(Openapi, DeclaresEveryPathParameter) {
  for (const auto& [path, item] : openapi().at("paths").items()) {
    std::set<std::string> declared;
    for (const auto& parameter : item.value("parameters", nlohmann::json::array())) {
      if (resolved(parameter).at("in") == "path") declared.insert(resolved(parameter)["name"]);
    }
    std::set<std::string> used;
    for (auto open = path.find('{'); open != std::string::npos; open = path.find('{', open + 1)) {
      used.insert(path.substr(open + 1, path.find('}', open) - open - 1));
    }
    EXPECT_EQ(declared, used) << path;
  }
}

TEST(Openapi, HasExamplesThatFitTheirSchemas) {
  int examples = 0;
  const SchemaCheck schemas(openapi(), false);
  for_each_node(openapi(), [&](const nlohmann::json& node) {
    if (!node.is_object() || !node.contains("schema") || !node.contains("examples")) return;
    for (const auto& [name, example] : node["examples"].items()) {
      ++examples;
      EXPECT_THAT(schemas.check(node["schema"], example.at("value")), IsEmpty()) << name;
    }
  });
  EXPECT_GT(examples, 30);
}

TEST(Openapi, HasAnExampleOfEveryJsonBody) {
  const auto expect_example = [](const nlohmann::json& node, const std::string& where) {
    const auto& content = resolved(node).value("content", nlohmann::json::object());
    if (!content.contains("application/json") || where.starts_with("get /openapi.json")) return;
    EXPECT_TRUE(content["application/json"].contains("examples")) << where;
    if (where.find(" /v1/") == std::string::npos) return;
    EXPECT_TRUE(content.contains("application/cbor")) << where;
    EXPECT_TRUE(content.contains("application/msgpack")) << where;
  };
  for_each_operation([&](const std::string& where, const nlohmann::json& operation) {
    if (operation.contains("requestBody")) expect_example(operation["requestBody"], where);
    for (const auto& [status, response] : operation["responses"].items()) {
      expect_example(response, where + " " + status);
    }
  });
}

template <typename Request>
void expect_taken(const Parsed<Request>& parsed, const std::string& example) {
  const auto* problem = std::get_if<Problem>(&parsed);
  EXPECT_EQ(problem, nullptr) << example << ": " << (problem != nullptr ? render(*problem) : "");
}

TEST(Openapi, HasRequestExamplesThatAreTaken) {
  const Lidar lidar{.angle_min = -2.4,
                    .angle_increment = 0.8,
                    .range_min = 0.1,
                    .range_max = 30.0,
                    .beams = {},
                    .T_base_link_laser = {}};
  using Take = std::function<void(const std::string&)>;
  const BodyFormat json = BodyFormat::kJson;
  const std::map<std::string, Take> takers{
      {"putMap", [&](auto& body) { expect_taken(parse_put_map(body, json), body); }},
      {"postMapScans",
       [&](auto& body) { expect_taken(parse_map_scans(body, json, lidar, {}), body); }},
      {"rollBack", [&](auto& body) { expect_taken(parse_roll_back(body, json), body); }},
      {"putTrajectory", [&](auto& body) { expect_taken(parse_trajectory(body, json), body); }},
      {"localize", [&](auto& body) { expect_taken(parse_localize(body, json, {}), body); }},
      {"createSession", [&](auto& body) { expect_taken(parse_create_session(body, json), body); }},
      {"postSessionScans",
       [&](auto& body) { expect_taken(parse_session_scans(body, json, lidar, {}), body); }},
      {"resetSession", [&](auto& body) { expect_taken(parse_reset(body, json), body); }},
  };
  std::set<std::string> taken;
  for_each_operation([&](const std::string& where, const nlohmann::json& operation) {
    if (!operation.contains("requestBody")) return;
    if (!operation["requestBody"]["content"].contains("application/json")) return;
    const std::string name = operation["operationId"];
    ASSERT_TRUE(takers.contains(name)) << where;
    for (const auto& example :
         operation["requestBody"]["content"]["application/json"]["examples"]) {
      takers.at(name)(example.at("value").dump());
      taken.insert(name);
    }
  });
  EXPECT_EQ(taken.size(), takers.size());
}

TEST(Openapi, NamesEveryOptionAndParameterWithItsDefault) {
  const std::function<void(const nlohmann::json&, const Json&)> expect_same =
      [&](const nlohmann::json& schema, const Json& defaults) {
        const auto& properties = schema.at("properties");
        EXPECT_EQ(properties.size(), defaults.size());
        for (const auto& [name, value] : defaults.items()) {
          ASSERT_TRUE(properties.contains(name)) << name;
          const auto& property = properties[name];
          if (value.is_object()) {
            EXPECT_EQ(property.value("additionalProperties", true), false) << name;
            expect_same(property, value);
          } else {
            EXPECT_EQ(property.at("default").dump(), value.dump()) << name;
          }
        }
      };
  const auto& schemas = openapi().at("components").at("schemas");
  expect_same(schemas.at("Options"), params_to_json(LocalizerParams{}));
  expect_same(schemas.at("Parameters"), params_to_json(MapperParams{}));
}

// What the service writes has all that is required and nothing that is not documented.

Answer answer_in_office() {
  const auto map = std::make_shared<const LocalizationMap>("office", 7, MapContent{});
  Answer answer;
  answer.status = Status::kLocalized;
  answer.pose = LocalizedPose{map, {1.0, 2.0, 3.0}, {}};
  answer.hypotheses = {{.map = map,
                        .T_map_base_link = {1.0, 2.0, 3.0},
                        .votes = 4,
                        .inliers = 5,
                        .score = 0.5,
                        .evidence = {}}};
  return answer;
}

TEST(OpenapiSchema, IsWhatAnswersFit) {
  EXPECT_THAT(misfits("Answer", render_answer({}, {"", std::nullopt, 0.0})), IsEmpty());
  const Json json = render_answer(answer_in_office(), {"s", 3, 12.5});
  EXPECT_THAT(misfits("Answer", json), IsEmpty());
  RobotScan scan;
  scan.scan = {1.0, 0.0, 0.5, 0.0, 10.0, {1.0F, 2.0F}};
  const std::vector<Point2> features{{1.0, 2.0}};
  EXPECT_THAT(misfits("AnswerWithPoints", with_points(json, scan, features)), IsEmpty());
}

TEST(OpenapiSchema, HasEveryStatusAndReason) {
  for (const Status status :
       {Status::kCollecting, Status::kAmbiguous, Status::kLocalized, Status::kLost}) {
    for (const Reason reason :
         {Reason::kNone, Reason::kNoReturns, Reason::kFewFeatures, Reason::kNoMotion,
          Reason::kNoMatch, Reason::kFewEvidence, Reason::kContradicted,
          Reason::kOdometryContradictsScans, Reason::kSearching, Reason::kPriorContradicted,
          Reason::kMirroredScans}) {
      Answer answer;
      answer.status = status;
      answer.reason = reason;
      EXPECT_THAT(misfits("Answer", render_answer(answer, {"s", 0, 0.0})), IsEmpty());
    }
  }
}

TEST(OpenapiSchema, IsWhatMapsFit) {
  MapEntry entry;
  entry.name = "office";
  EXPECT_THAT(misfits("Map", render_map(entry)), IsEmpty());
  entry.lidar = Lidar{-1.0, 0.5, 0.1, 10.0, 3, {}};
  entry.bounds = Bounds{{0.0, 0.0}, {1.0, 1.0}};
  const std::vector<MapEntry> entries{entry};
  EXPECT_THAT(misfits("MapList", render_map_list(entries, "office")), IsEmpty());
  EXPECT_THAT(misfits("MapBatch", render_map_batch({})), IsEmpty());
}

TEST(OpenapiSchema, IsWhatFeaturesFit) {
  const std::vector<Feature> features{{.position = {0.0, 0.0}}, {.position = {1.0, 0.0}}};
  EXPECT_THAT(misfits("FeatureList", render_features(1, features, std::nullopt)), IsEmpty());
  const auto descriptor = describe_one(features, 0, {});
  EXPECT_THAT(misfits("Descriptor", render_descriptor(1, 0, {}, descriptor)), IsEmpty());
}

TEST(OpenapiSchema, IsWhatSessionsFit) {
  const std::vector<std::string> maps{"office"};
  const Json answer = render_answer(Answer{}, {"s", 0, 0.0});
  SessionEntry entry;
  entry.id = "s";
  entry.robot = "r2";
  entry.lidars.only = Lidar{-1.0, 0.5, 0.1, 10.0, {}, {}};
  EXPECT_THAT(misfits("Session", render_session(entry)), IsEmpty());
  entry.maps = maps;
  entry.last_answer = &answer;
  entry.superseded_by = "t";
  entry.region = StartRegion{
      .map = "office", .center = {1.0, 2.0}, .radius_m = 3.0, .yaw = 0.5, .yaw_tolerance_rad = 0.8};
  EXPECT_THAT(misfits("Session", render_session(entry)), IsEmpty());
  Lidars lidars;
  lidars.by_name["front"] = {-1.0, 0.5, 0.1, 10.0, {}, {}};
  lidars.by_name["front"].tilt = {.roll = 3.1, .pitch = 0.1};
  entry.lidars = lidars;
  const Json session = render_session(entry);
  EXPECT_THAT(misfits("Session", session), IsEmpty());
  EXPECT_TRUE(session["lidar"].is_null());
  EXPECT_EQ(session["lidars"]["front"]["mount"]["pitch"], 0.1);
}

TEST(OpenapiSchema, IsWhatProfilesFit) {
  const Json nothing = render_answer({}, {"s", 0, 0.0});
  for (const Json& one : {nothing, render_answer(answer_in_office(), {"s", 3, 12.5})}) {
    EXPECT_THAT(misfits("RosAnswer", in_profile(one, AnswerProfile::kRos)), IsEmpty());
    EXPECT_THAT(misfits("Vda5050State", in_profile(one, AnswerProfile::kVda5050)), IsEmpty());
  }
}

TEST(OpenapiSchema, IsWhatProblemsFit) {
  Problem problem = make_problem(ErrorCode::kInvalidArgument, "wrong");
  problem.errors.push_back({"/scans", "is needed"});
  problem.conflict = {.expected = 3, .last_stamp = std::nullopt};
  EXPECT_THAT(misfits("Problem", Json::parse(render(problem))), IsEmpty());
}

TEST(SchemaCheck, FindsWhatDoesNotFit) {
  EXPECT_THAT(misfits("Health", Json{{"status", 1}}), ::testing::SizeIs(1));
  EXPECT_THAT(misfits("Health", Json::object()), ::testing::SizeIs(1));
  EXPECT_THAT(misfits("Health", Json{{"status", "ok"}, {"extra", 1}}), ::testing::SizeIs(1));
  EXPECT_THAT(misfits("Status", Json("asleep")), ::testing::SizeIs(1));
}

}  // namespace
}  // namespace cornerfix::api

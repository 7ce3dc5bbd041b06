#include "api/json_codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

namespace cornerfix::api {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

LocalizationMapPtr office() {
  static const auto map = std::make_shared<const LocalizationMap>("office-2", 7, MapContent{});
  return map;
}

Answer localized_answer() {
  Answer answer;
  answer.status = Status::kLocalized;
  answer.pose = LocalizedPose{office(), {4.5, -0.75, 1.5}, {1, 0, 0, 0, 2, 0, 0, 0, 3}};
  answer.confidence = 0.998;
  answer.hypotheses = {{.map = office(),
                        .T_map_base_link = {4.5, -0.75, 1.5},
                        .votes = 31,
                        .inliers = 12,
                        .score = 0.875,
                        .evidence = {}}};
  answer.terms.explained_share = 0.9375;
  answer.terms.unknown_share = 0.125;
  answer.terms.margin_per_hit = 0.25;
  answer.terms.probability_explained = 0.999;
  answer.terms.probability_best = 0.99899;
  answer.odometry = OdometryUse::kWeightedDown;
  answer.pose->epoch = 3;
  answer.pose->confirmed = true;
  answer.local_scans = 40;
  answer.local_features = 23;
  answer.T_submap_base_link = {1.0, 2.0, 0.5};
  answer.times = {0.5, 0.25, 3.0, 1.0, 0.125, 4.875};
  return answer;
}

TEST(RenderAnswer, IsTheExampleOfTheContract) {
  const Json json = render_answer(localized_answer(), {"s-1", 12, 1284.2});
  EXPECT_EQ(json.dump(), Json::parse(R"({
    "session": "s-1", "sequence": 12, "status": "localized",
    "pose": {"map": "office-2", "revision": 7, "stamp": 1284.2, "x": 4.5, "y": -0.75, "yaw": 1.5,
             "covariance": [1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0],
             "epoch": 3, "confirmed": true},
    "confidence": 0.998,
    "hypotheses": [{"map": "office-2", "revision": 7, "x": 4.5, "y": -0.75, "yaw": 1.5,
                    "votes": 31, "inliers": 12, "score": 0.875}],
    "given": null,
    "explanation": {"explained_share": 0.938, "unknown_share": 0.125, "margin_per_hit": 0.25,
                    "probability_explained": 0.999, "probability_best": 0.999},
    "reason": null, "odometry": "weighted_down",
    "local": {"scans": 40, "features": 23, "pose": {"x": 1.0, "y": 2.0, "yaw": 0.5}},
    "timing_ms": {"odometry": 0.5, "extract": 0.25, "match": 3.0, "verify": 1.0, "track": 0.125,
                  "total": 4.875}})")
                             .dump());
}

TEST(RenderAnswer, HasNoPoseUnlessLocalized) {
  Answer answer = localized_answer();
  for (const Status status : {Status::kCollecting, Status::kAmbiguous, Status::kLost}) {
    answer.status = status;
    EXPECT_TRUE(render_answer(answer, {"s", 0, 0.0}).at("pose").is_null());
  }
}

TEST(RenderAnswer, StatesHowManyMapsWereConsideredIfTheyAreSeveral) {
  Answer answer;
  answer.searched_maps = 1;
  EXPECT_FALSE(render_answer(answer, {"s", 0, 1.0}).contains("searched_maps"));
  answer.searched_maps = 100;
  EXPECT_EQ(render_answer(answer, {"s", 0, 1.0})["searched_maps"], 100);
}

TEST(RenderAnswer, SaysWhatIsMissing) {
  Answer answer;
  answer.reason = Reason::kFewFeatures;
  const Json json = render_answer(answer, {"s", 0, 0.0});
  EXPECT_EQ(json.at("status"), "collecting");
  EXPECT_EQ(json.at("reason"), "few_features");
}

TEST(RenderAnswer, OfAStatelessQuestionHasNoSession) {
  const Json json = render_answer(Answer{}, {"", std::nullopt, 0.0});
  EXPECT_TRUE(json.at("session").is_null());
  EXPECT_TRUE(json.at("sequence").is_null());
}

TEST(RenderAnswer, WritesNullForWhatIsNotFinite) {
  Answer answer = localized_answer();
  answer.confidence = kNaN;
  answer.pose->covariance[0] = kInfinity;
  answer.hypotheses[0].score = -kInfinity;
  answer.times.total_ms = kNaN;
  const Json json = render_answer(answer, {"s", 0, kNaN});
  EXPECT_TRUE(json.at("confidence").is_null());
  EXPECT_TRUE(json.at("pose").at("stamp").is_null());
  EXPECT_TRUE(json.at("pose").at("covariance").at(0).is_null());
  EXPECT_TRUE(json.at("hypotheses").at(0).at("score").is_null());
  EXPECT_TRUE(json.at("timing_ms").at("total").is_null());
}

TEST(WithPoints, GivesReturnsAndFeaturesInBaseLinkToTheMillimetre) {
  RobotScan scan;
  scan.scan = {.stamp = 1.0,
               .angle_min = 0.0,
               .angle_increment = 0.5,
               .range_min = 0.1,
               .range_max = 10.0,
               .ranges = {2.00049F, std::nanf(""), 99.0F}};
  scan.T_base_link_laser = {0.25, -0.5, 0.0};
  const std::vector<Point2> features{{1.0004, -2.0006}};
  const Json json = with_points(Json::object(), scan, features);
  EXPECT_EQ(json.at("scan_points").dump(), "[[2.25,-0.5]]");
  EXPECT_EQ(json.at("feature_points").dump(), "[[1.0,-2.001]]");
}

TEST(RenderMap, TellsParametersInForceAndNoBoundsWhenEmpty) {
  MapEntry entry;
  entry.name = "office-2";
  entry.revision = 1;
  entry.parameters.grid.resolution_m = 0.1;
  const Json json = render_map(entry);
  EXPECT_TRUE(json.at("bounds").is_null());
  EXPECT_TRUE(json.at("lidar").is_null());
  EXPECT_EQ(json.at("parameters").at("grid").at("resolution_m"), 0.1);
  EXPECT_EQ(json.at("parameters").at("key_frame_distance_m"), MapperParams{}.key_frame_distance_m);
}

TEST(RenderMapList, EndsWithANullToken) {
  const std::vector<MapEntry> maps(2);
  EXPECT_EQ(render_map_list(maps, "office").at("next_page_token"), "office");
  const Json last = render_map_list(maps, std::nullopt);
  EXPECT_TRUE(last.at("next_page_token").is_null());
  EXPECT_EQ(last.at("maps").size(), 2U);
}

TEST(RenderFeatures, KeepsTheIdsOfThoseInTheBox) {
  const std::vector<Feature> features{{.position = {0.0, 0.0}}, {.position = {5.0, 5.0}}};
  const Json all = render_features(3, features, std::nullopt);
  EXPECT_EQ(all.at("features").size(), 2U);
  const Json some = render_features(3, features, Bounds{{4.0, 4.0}, {5.0, 5.0}});
  ASSERT_EQ(some.at("features").size(), 1U);
  EXPECT_EQ(some.at("features").at(0).at("id"), 1);
  EXPECT_EQ(some.at("revision"), 3);
}

TEST(RenderDescriptor, HasAnEntryForEachOtherFeature) {
  const std::vector<Feature> features{{.position = {0.0, 0.0}}, {.position = {1.0, 0.0}}};
  const Json json = render_descriptor(4, 1, {}, describe_one(features, 1, {}));
  EXPECT_EQ(json.at("feature"), 1);
  ASSERT_EQ(json.at("entries").size(), 1U);
  EXPECT_EQ(json.at("entries").at(0).at("feature"), 0);
  EXPECT_EQ(json.at("entries").at(0).at("distance_bin"), 5);
}

TEST(RenderSession, TellsMapsAndWhereToGoOn) {
  const std::vector<std::string> one{"a"};
  const std::vector<std::string> two{"a", "b"};
  SessionEntry entry;
  entry.id = "s-1";
  entry.robot = "r2";
  entry.expected = 5;
  EXPECT_TRUE(render_session(entry).at("map").is_null());
  EXPECT_TRUE(render_session(entry).at("maps").is_null());
  entry.maps = one;
  EXPECT_EQ(render_session(entry).at("map"), "a");
  entry.maps = two;
  const Json json = render_session(entry);
  EXPECT_TRUE(json.at("map").is_null());
  EXPECT_EQ(json.at("maps").size(), 2U);
  EXPECT_EQ(json.at("expected"), 5);
  EXPECT_EQ(json.at("options").at("method"), "indexed");
  EXPECT_TRUE(json.at("last_answer").is_null());
}

TEST(Encode, IsTheSameDocumentInEveryFormat) {
  const Json json = render_answer(localized_answer(), {"s-1", 12, 1284.2});
  EXPECT_EQ(Json::parse(encode(json, BodyFormat::kJson)), json);
  EXPECT_EQ(Json::from_cbor(encode(json, BodyFormat::kCbor)), json);
  EXPECT_EQ(Json::from_msgpack(encode(json, BodyFormat::kMessagePack)), json);
}

TEST(Encode, ReplacesBytesThatAreNotUtf8) {
  EXPECT_EQ(encode(Json{{"description", "\xff"}}, BodyFormat::kJson),
            "{\"description\":\"\xEF\xBF\xBD\"}");
}

TEST(MediaType, NamesEveryFormat) {
  EXPECT_EQ(media_type(BodyFormat::kJson), "application/json");
  EXPECT_EQ(media_type(BodyFormat::kCbor), "application/cbor");
  EXPECT_EQ(media_type(BodyFormat::kMessagePack), "application/msgpack");
}

}  // namespace
}  // namespace cornerfix::api

#include "api/requests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "unit/api/scan_text.hpp"

namespace cornerfix::api {
namespace {

using testing::ElementsAre;
using testing::FloatEq;
using testing::NanSensitiveFloatEq;

constexpr double kPi = std::numbers::pi;
const float kNoReturn = std::numeric_limits<float>::quiet_NaN();

/// The request, or a failed test that prints the problem.
template <typename Request>
Request taken(Parsed<Request> parsed) {
  if (const auto* problem = std::get_if<Problem>(&parsed)) {
    ADD_FAILURE() << render(*problem);
    return {};
  }
  return std::get<Request>(std::move(parsed));
}

SessionScansRequest session_scans(const std::string& scans) {
  return taken(
      parse_session_scans(session_batch(scans), BodyFormat::kJson, three_beam_lidar(), {}));
}

TEST(SessionScans, HaveTheLidarsGeometryAndTheirOwnValues) {
  Lidar lidar = three_beam_lidar();
  lidar.T_base_link_laser = {0.2, 0.0, kPi};
  const auto request = taken(parse_session_scans(
      R"({"sequence": 7, "scans": [{"stamp": 12.5, "ranges": [1, 2.5, 3],
                                    "odom": {"x": 1, "y": -2, "yaw": 0.5}}]})",
      BodyFormat::kJson, lidar, {}));
  EXPECT_EQ(request.sequence, 7U);
  ASSERT_EQ(request.scans.size(), 1U);
  const RobotScan& scan = request.scans[0];
  EXPECT_EQ(scan.scan.stamp, 12.5);
  EXPECT_EQ(scan.scan.angle_min, -1.0);
  EXPECT_EQ(scan.scan.angle_increment, 0.5);
  EXPECT_EQ(scan.scan.range_min, 0.1);
  EXPECT_EQ(scan.scan.range_max, 10.0);
  EXPECT_THAT(scan.scan.ranges, ElementsAre(1.0F, 2.5F, 3.0F));
  EXPECT_EQ(scan.T_base_link_laser, (Pose2{0.2, 0.0, kPi}));
  EXPECT_EQ(scan.T_odom_base_link, (Pose2{1.0, -2.0, 0.5}));
}

TEST(SessionScans, TakeNullAndNumbersBeyondTheLimitsAsNoReturn) {
  const auto request = session_scans(R"({"stamp": 1, "ranges": [null, 1e999, -1e999]},
                                        {"stamp": 2, "ranges": [1e300, 0.05, -3]})");
  ASSERT_EQ(request.scans.size(), 2U);
  for (const RobotScan& scan : request.scans) {
    for (std::size_t beam = 0; beam < 3; ++beam) EXPECT_FALSE(scan.scan.has_return(beam));
  }
}

TEST(SessionScans, TakeNumbersInAnyNotation) {
  const auto request = session_scans(
      R"({"stamp": 1.2e3, "ranges": [1E0, 0.25e1, 3.000000000000000000000000000000000001]})");
  EXPECT_EQ(request.scans.at(0).scan.stamp, 1200.0);
  EXPECT_THAT(request.scans.at(0).scan.ranges, ElementsAre(1.0F, 2.5F, 3.0F));
}

TEST(SessionScans, TakeIntegersThatNoMachineTypeHolds) {
  const auto request = session_scans(R"({"stamp": 1, "ranges": [100000000000000000000000, 2, 3]})");
  EXPECT_FALSE(request.scans.at(0).scan.has_return(0));
  EXPECT_TRUE(request.scans.at(0).scan.has_return(1));
}

TEST(SessionScans, WrapTheYawOfOdometry) {
  const auto request = session_scans(
      R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 0, "y": 0, "yaw": -3.141592653589793}},
         {"stamp": 2, "ranges": [1, 2, 3], "odom": {"x": 0, "y": 0, "yaw": 7}})");
  EXPECT_DOUBLE_EQ(request.scans.at(0).T_odom_base_link->yaw, kPi);
  EXPECT_DOUBLE_EQ(request.scans.at(1).T_odom_base_link->yaw, 7.0 - 2.0 * kPi);
}

TEST(SessionScans, TakeNullOdometryAsNone) {
  const auto request = session_scans(R"({"stamp": 1, "ranges": [1, 2, 3], "odom": null})");
  EXPECT_FALSE(request.scans.at(0).T_odom_base_link.has_value());
}

TEST(SessionScans, TakeUnusedMembersOfALaserScanOfAnyType) {
  const auto request = session_scans(
      R"({"stamp": 1, "ranges": [1, 2, 3], "intensities": [1, "x", {"y": [null]}],
          "angle_max": null, "scan_time": {},
          "header": {"seq": [], "frame_id": 7}})");
  EXPECT_THAT(request.scans.at(0).scan.ranges, ElementsAre(1.0F, 2.0F, 3.0F));
}

TEST(SessionScans, TakeOdometryAsRosbridgeSendsIt) {
  const auto request = session_scans(R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {
      "header": {"seq": 1, "stamp": {"secs": 1, "nsecs": 0}, "frame_id": "odom"},
      "child_frame_id": "base_footprint",
      "pose": {"pose": {"position": {"x": 1.5, "y": -2.0, "z": 0.1},
                        "orientation": {"x": 0, "y": 0, "z": 0.7071067811865476,
                                        "w": 0.7071067811865476}},
               "covariance": [0, 0, 0]},
      "twist": {"twist": {}, "covariance": []}}})");
  const auto& T_odom_base_link = request.scans.at(0).T_odom_base_link;
  ASSERT_TRUE(T_odom_base_link);
  EXPECT_EQ(T_odom_base_link->x, 1.5);
  EXPECT_EQ(T_odom_base_link->y, -2.0);
  EXPECT_NEAR(T_odom_base_link->yaw, kPi / 2.0, 1e-12);
}

TEST(SessionScans, AreStraightenedByTheOdometryOfTheirBatch) {
  // Turning left by 0.1 rad in the second that a scan of four beams takes.
  const std::string scan = R"("time_increment": 0.2, "ranges": [1, 1, 1])";
  const auto request =
      session_scans(R"({"stamp": 1.0, "odom": {"x": 0, "y": 0, "yaw": 0}, )" + scan +
                    R"(}, {"stamp": 2.0, "odom": {"x": 0, "y": 0, "yaw": 0.1}, )" + scan +
                    R"(}, {"stamp": 2.5, )" + scan + "}");
  EXPECT_NEAR(request.scans.at(0).scan.angle_increment, 0.5 + 0.02, 1e-12);
  EXPECT_NEAR(request.scans.at(1).scan.angle_increment, 0.5 + 0.02, 1e-12);
  EXPECT_EQ(request.scans.at(2).scan.angle_increment, 0.5);
}

TEST(SessionScans, TakeARangeMaxOfNullBesideAnglesForNoLimit) {
  const auto request = session_scans(
      R"({"stamp": 1, "angle_min": -1, "angle_increment": 0.5, "range_max": null,
          "ranges": [1, 2, 1000]})");
  EXPECT_TRUE(request.scans.at(0).scan.has_return(2));
}

TEST(SessionScans, TakeAnInfiniteRangeMaxInCbor) {
  nlohmann::json body = nlohmann::json::parse(
      session_batch(R"({"stamp": 1, "angle_min": 0, "ranges": [1, 2, 1000]})"));
  body["scans"][0]["range_max"] = std::numeric_limits<double>::infinity();
  const auto bytes = nlohmann::json::to_cbor(body);
  const auto request =
      taken(parse_session_scans({reinterpret_cast<const char*>(bytes.data()), bytes.size()},
                                BodyFormat::kCbor, three_beam_lidar(), {}));
  EXPECT_TRUE(request.scans.at(0).scan.has_return(2));
}

TEST(SessionScans, TakeMembersInAnyOrderAndEscapedNames) {
  const auto request = taken(
      parse_session_scans(R"({"scans": [{"rang\u0065s": [1, 2, 3], "stamp": 4}], "sequence": 3.0})",
                          BodyFormat::kJson, three_beam_lidar(), {}));
  EXPECT_EQ(request.sequence, 3U);
  EXPECT_THAT(request.scans.at(0).scan.ranges, ElementsAre(1.0F, 2.0F, 3.0F));
}

TEST(SessionScans, TakeARos1LaserScanAsRosbridgeSendsIt) {
  const auto request = session_scans(R"({
      "header": {"seq": 9, "stamp": {"secs": 1284, "nsecs": 250000000}, "frame_id": "laser"},
      "angle_min": -0.5, "angle_max": 0.5, "angle_increment": 0.25, "time_increment": 0.0,
      "scan_time": 0.1, "range_min": 0.2, "range_max": 30.0,
      "ranges": [1.5, null, 2.5], "intensities": [10, 20, 30]})");
  const LaserScan& scan = request.scans.at(0).scan;
  EXPECT_DOUBLE_EQ(scan.stamp, 1284.25);
  EXPECT_EQ(scan.angle_min, -0.5);
  EXPECT_EQ(scan.angle_increment, 0.25);
  EXPECT_EQ(scan.range_min, 0.2);
  EXPECT_EQ(scan.range_max, 30.0);
  EXPECT_THAT(scan.ranges, ElementsAre(FloatEq(1.5F), NanSensitiveFloatEq(kNoReturn), 2.5F));
}

TEST(SessionScans, TakeARos2StampAndKeepTheLidarWhereTheMessageHasNull) {
  const auto request = session_scans(R"({
      "header": {"stamp": {"sec": 5, "nanosec": 500000000}, "frame_id": "laser"},
      "range_max": null, "ranges": [1, 2, 3], "odom": {"x": 1, "y": 2, "yaw": 3}})");
  EXPECT_DOUBLE_EQ(request.scans.at(0).scan.stamp, 5.5);
  EXPECT_EQ(request.scans.at(0).scan.range_max, 10.0);
  EXPECT_TRUE(request.scans.at(0).T_odom_base_link.has_value());
}

TEST(SessionScans, PreferTheStampBesideAHeader) {
  const auto request = session_scans(
      R"({"stamp": 3, "header": {"stamp": {"sec": 5, "nanosec": 0}}, "ranges": [1, 2, 3]})");
  EXPECT_EQ(request.scans.at(0).scan.stamp, 3.0);
}

TEST(SessionScans, TakeAnyNumberOfRangesWhenTheLidarHasNoBeams) {
  Lidar lidar = three_beam_lidar();
  lidar.beams.reset();
  const auto request = taken(parse_session_scans(
      session_batch(R"({"stamp": 1, "ranges": [1, 2]}, {"stamp": 2, "ranges": [1]})"),
      BodyFormat::kJson, lidar, {}));
  EXPECT_THAT(request.scans.at(0).scan.ranges, ElementsAre(1.0F, 2.0F));
  EXPECT_THAT(request.scans.at(1).scan.ranges, ElementsAre(1.0F));
}

TEST(SessionScans, TakeAnyNumberOfRangesOfAScanWithItsOwnAngles) {
  const auto request =
      session_scans(R"({"stamp": 1, "angle_min": -1, "angle_increment": 0.25, "ranges": [1, 2]})");
  EXPECT_THAT(request.scans.at(0).scan.ranges, ElementsAre(1.0F, 2.0F));
  EXPECT_EQ(request.scans.at(0).scan.range_max, 10.0);
  const auto shorter =
      parse_session_scans(session_batch(R"({"stamp": 1, "range_max": 5, "ranges": [1, 2]})"),
                          BodyFormat::kJson, three_beam_lidar(), {});
  EXPECT_EQ(std::get<Problem>(shorter).errors.at(0).detail,
            "2 values, expected 3 (from lidar.beams)");
}

TEST(SessionScans, TakeAsManyScansAndBeamsAsTheLimitsAllow) {
  const RequestLimits limits{.max_scans = 2, .max_beams = 3};
  const auto parse = [&](const std::string& scans) {
    return parse_session_scans(session_batch(scans), BodyFormat::kJson, three_beam_lidar(), limits);
  };
  const std::string two = R"({"stamp": 1, "ranges": [1, 2, 3]}, {"stamp": 2, "ranges": [1, 2, 3]})";
  EXPECT_EQ(taken(parse(two)).scans.size(), 2U);
  EXPECT_EQ(std::get<Problem>(parse(two + R"(, {"stamp": 3, "ranges": []})")).status, 413);
  EXPECT_EQ(std::get<Problem>(parse(R"({"stamp": 1, "ranges": [1, 2, 3, 4]})")).status, 413);
}

TEST(SessionScans, AreTheSameInEveryFormat) {
  const nlohmann::json batch = nlohmann::json::parse(R"({"sequence": 4, "scans": [
      {"stamp": 12.5, "ranges": [1, null, 3.25], "odom": {"x": 1, "y": -2, "yaw": 0.5}},
      {"stamp": 13, "ranges": [0, -4, 2]}]})");
  for (const BodyFormat format : {BodyFormat::kJson, BodyFormat::kCbor, BodyFormat::kMessagePack}) {
    const auto request =
        taken(parse_session_scans(encode_as(batch, format), format, three_beam_lidar(), {}));
    EXPECT_EQ(request.sequence, 4U);
    ASSERT_EQ(request.scans.size(), 2U);
    EXPECT_THAT(request.scans[0].scan.ranges,
                ElementsAre(1.0F, NanSensitiveFloatEq(kNoReturn), 3.25F));
    EXPECT_THAT(request.scans[1].scan.ranges, ElementsAre(0.0F, -4.0F, 2.0F));
    EXPECT_EQ(request.scans[0].T_odom_base_link, (Pose2{1.0, -2.0, 0.5}));
  }
}

TEST(SessionScans, TakeNanAndInfinityOfBinaryFormatsAsNoReturn) {
  nlohmann::json batch =
      nlohmann::json::parse(session_batch(R"({"stamp": 1, "ranges": [0, 0, 2]})"));
  batch["scans"][0]["ranges"][0] = std::numeric_limits<double>::quiet_NaN();
  batch["scans"][0]["ranges"][1] = std::numeric_limits<double>::infinity();
  for (const BodyFormat format : {BodyFormat::kCbor, BodyFormat::kMessagePack}) {
    const auto request =
        taken(parse_session_scans(encode_as(batch, format), format, three_beam_lidar(), {}));
    const LaserScan& scan = request.scans.at(0).scan;
    EXPECT_FALSE(scan.has_return(0));
    EXPECT_FALSE(scan.has_return(1));
    EXPECT_TRUE(scan.has_return(2));
  }
}

TEST(SessionScans, RefuseNanInAPoseOfABinaryFormat) {
  nlohmann::json batch = nlohmann::json::parse(
      session_batch(R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 0, "y": 0, "yaw": 0}})"));
  batch["scans"][0]["odom"]["yaw"] = std::numeric_limits<double>::quiet_NaN();
  const auto parsed = parse_session_scans(encode_as(batch, BodyFormat::kCbor), BodyFormat::kCbor,
                                          three_beam_lidar(), {});
  EXPECT_EQ(std::get<Problem>(parsed).errors.at(0).pointer, "/scans/0/odom/yaw");
}

TEST(MapScans, TakePosesAndTheMapsLidar) {
  const auto request = taken(parse_map_scans(
      R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3], "pose": {"x": 1, "y": 2, "yaw": 10}}]})",
      BodyFormat::kJson, three_beam_lidar(), {}));
  ASSERT_EQ(request.scans.size(), 1U);
  EXPECT_EQ(request.scans[0].T_map_base_link, (Pose2{1.0, 2.0, wrap_angle(10.0)}));
  EXPECT_EQ(request.scans[0].scan.angle_min, -1.0);
  EXPECT_EQ(request.lidar, three_beam_lidar());
}

TEST(MapScans, AreADriveWhereNoneHasAPose) {
  const auto request = taken(parse_map_scans(
      R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 1, "y": 2, "yaw": 10}},
                    {"stamp": 2, "ranges": [1, 2, 3], "pose": null}]})",
      BodyFormat::kJson, three_beam_lidar(), {}));
  EXPECT_TRUE(request.scans.empty());
  ASSERT_EQ(request.unposed_scans.size(), 2U);
  EXPECT_EQ(request.unposed_scans[0].T_odom_base_link, (Pose2{1.0, 2.0, wrap_angle(10.0)}));
  EXPECT_FALSE(request.unposed_scans[1].T_odom_base_link);
}

TEST(MapScans, PreferTheLidarOfTheBodyAndCountItsBeams) {
  const auto request = taken(parse_map_scans(
      R"({"lidar": {"angle_min": 0, "angle_increment": 0.1, "range_min": 0, "range_max": 5,
                    "mount": {"x": 0.3, "y": 0, "yaw": 0}},
          "scans": [{"stamp": 1, "ranges": [1, 2], "pose": {"x": 0, "y": 0, "yaw": 0}}]})",
      BodyFormat::kJson, three_beam_lidar(), {}));
  ASSERT_TRUE(request.lidar.has_value());
  EXPECT_EQ(request.lidar->beams, std::nullopt);
  EXPECT_EQ(request.scans.at(0).scan.range_max, 5.0);
  EXPECT_EQ(request.scans.at(0).T_base_link_laser, (Pose2{0.3, 0.0, 0.0}));
}

TEST(MapScans, TakeAnyOrderOfStamps) {
  const auto request = taken(parse_map_scans(
      R"({"scans": [{"stamp": 2, "ranges": [1, 2, 3], "pose": {"x": 0, "y": 0, "yaw": 0}},
                    {"stamp": 1, "ranges": [1, 2, 3], "pose": {"x": 0, "y": 0, "yaw": 0}}]})",
      BodyFormat::kJson, three_beam_lidar(), {}));
  EXPECT_EQ(request.scans.size(), 2U);
}

TEST(MapScans, NeedNoLidarWhenEachScanBringsItsGeometry) {
  const auto request = taken(parse_map_scans(
      R"({"scans": [{"stamp": 1, "ranges": [1, 2], "angle_min": 0, "angle_increment": 0.1,
                     "range_min": 0, "range_max": 5, "pose": {"x": 0, "y": 0, "yaw": 0}}]})",
      BodyFormat::kJson, std::nullopt, {}));
  EXPECT_EQ(request.scans.size(), 1U);
  EXPECT_FALSE(request.lidar.has_value());
}

TEST(PutMap, TakesAnEmptyObject) {
  const auto request = taken(parse_put_map("{}", BodyFormat::kJson));
  EXPECT_FALSE(request.description || request.lidar_json || request.parameters_json);
}

TEST(PutMap, TakesNullAsAbsent) {
  const auto request = taken(parse_put_map(
      R"({"description": null, "lidar": null, "parameters": null})", BodyFormat::kJson));
  EXPECT_FALSE(request.description || request.lidar_json || request.parameters_json);
}

TEST(PutMap, KeepsTextsThatGiveTheSameValuesBack) {
  const auto request = taken(parse_put_map(
      R"({"description": "Büro 2", "lidar": {"angle_min": -1.5, "angle_increment": 0.01,
          "range_min": 0.05, "range_max": 30, "beams": 300,
          "mount": {"x": 0.1, "y": 0.2, "yaw": 4}},
          "parameters": {"key_frame_distance_m": 0.5, "extractor": "vfp", "grid": {"resolution_m": 0.1}}})",
      BodyFormat::kJson));
  EXPECT_EQ(request.description, "Büro 2");
  const auto lidar = lidar_from_json(request.lidar_json.value_or(""));
  ASSERT_TRUE(lidar.has_value());
  EXPECT_EQ(lidar->beams, 300U);
  EXPECT_EQ(lidar->T_base_link_laser, (Pose2{0.1, 0.2, wrap_angle(4.0)}));
  const MapperParams params = mapper_params_from_json(request.parameters_json.value_or(""));
  EXPECT_EQ(params.key_frame_distance_m, 0.5);
  EXPECT_EQ(params.grid.resolution_m, 0.1);
  EXPECT_EQ(params.extractor, CornerExtractor::kVfp);
  EXPECT_EQ(params.min_feature_count, MapperParams{}.min_feature_count);
}

TEST(StoredTexts, GiveDefaultsWhenEmpty) {
  EXPECT_FALSE(lidar_from_json("").has_value());
  EXPECT_EQ(params_from_json("").seed, LocalizerParams{}.seed);
  EXPECT_EQ(mapper_params_from_json("").grid.resolution_m, MapperParams{}.grid.resolution_m);
}

TEST(StoredTexts, GiveALidarBackToTheLastBit) {
  Lidar lidar{.angle_min = -2.356194490192345,
              .angle_increment = 0.004363323129985824,
              .range_min = 0.023,
              .range_max = 60.0,
              .beams = 1081,
              .T_base_link_laser = {0.1 + 0.2, -1.0 / 3.0, kPi}};
  EXPECT_EQ(lidar_from_json(lidar_to_json(lidar)), lidar);
  lidar.beams.reset();
  EXPECT_EQ(lidar_from_json(lidar_to_json(lidar)), lidar);
}

TEST(StoredTexts, GiveALidarWithoutLimitBack) {
  const auto request = taken(parse_put_map(
      R"({"lidar": {"angle_min": 0, "angle_increment": 0.1, "range_min": 0, "range_max": null}})",
      BodyFormat::kJson));
  const std::string stored = request.lidar_json.value_or("");
  EXPECT_THAT(stored, testing::HasSubstr(R"("range_max":null)"));
  const auto lidar = lidar_from_json(stored);
  ASSERT_TRUE(lidar.has_value());
  EXPECT_EQ(lidar->range_max, std::numeric_limits<double>::infinity());
  EXPECT_TRUE(is_put_map_request("", stored, ""));
}

TEST(CreateSession, TakesOneMapSomeMapsOrAll) {
  const auto maps_of = [](const std::string& members) {
    return taken(parse_create_session(
                     std::string(R"({"robot": "r2", "lidar": )") + kLidarText + members + "}",
                     BodyFormat::kJson))
        .maps;
  };
  EXPECT_THAT(maps_of(""), ElementsAre());
  EXPECT_THAT(maps_of(R"(, "map": null)"), ElementsAre());
  EXPECT_THAT(maps_of(R"(, "map": "a")"), ElementsAre("a"));
  EXPECT_THAT(maps_of(R"(, "map": null, "maps": ["b", "a", "b"])"), ElementsAre("b", "a"));
}

TEST(CreateSession, AppliesOptionsToTheDefaults) {
  const auto request = taken(parse_create_session(
      std::string(R"({"robot": "r2", "lidar": )") + kLidarText +
          R"(, "options": {"method": "nma", "extractor": "vfp", "seed": 18446744073709551615,
                           "acceptance": {"min_probability": 0.99}, "min_votes": null}})",
      BodyFormat::kJson));
  EXPECT_EQ(request.params.method, Method::kNma);
  EXPECT_EQ(request.params.extractor, CornerExtractor::kVfp);
  EXPECT_EQ(request.params.seed, 18446744073709551615ULL);
  EXPECT_EQ(request.params.acceptance.min_probability, 0.99);
  EXPECT_EQ(request.params.min_votes, LocalizerParams{}.min_votes);
  EXPECT_EQ(params_from_json(request.options_json).acceptance.min_probability, 0.99);
  EXPECT_EQ(params_from_json(request.options_json).seed, request.params.seed);
}

Parsed<CreateSessionRequest> session_near(const std::string& near) {
  return parse_create_session(
      std::string(R"({"robot": "r2", "lidar": )") + kLidarText + R"(, "near": )" + near + "}",
      BodyFormat::kJson);
}

TEST(CreateSession, TakesWhereTheRobotMayBe) {
  EXPECT_FALSE(taken(session_near("null")).region.has_value());
  EXPECT_EQ(taken(session_near(R"({"x": 1.5, "y": -2, "radius_m": 3})")).region,
            (StartRegion{.center = {1.5, -2.0}, .radius_m = 3.0}));
  EXPECT_EQ(taken(session_near(R"({"map": "a", "x": 1, "y": 2, "radius_m": 3, "yaw": 7,
                                   "yaw_tolerance_rad": 0.25})"))
                .region,
            (StartRegion{.map = "a",
                         .center = {1.0, 2.0},
                         .radius_m = 3.0,
                         .yaw = wrap_angle(7.0),
                         .yaw_tolerance_rad = 0.25}));
  EXPECT_EQ(
      taken(session_near(R"({"x": 1, "y": 2, "radius_m": 3, "yaw": 0})")).region->yaw_tolerance_rad,
      0.8);
}

TEST(CreateSession, SaysWhichMemberOfNearIsWrong) {
  const auto pointer_of = [](const std::string& near) {
    const auto parsed = session_near(near);
    const auto* problem = std::get_if<Problem>(&parsed);
    if (problem == nullptr || problem->errors.size() != 1) return std::string("not one error");
    EXPECT_EQ(problem->status, 422);
    return problem->errors.front().pointer;
  };
  EXPECT_EQ(pointer_of("5"), "/near");
  EXPECT_EQ(pointer_of(R"({"y": 2, "radius_m": 3})"), "/near/x");
  EXPECT_EQ(pointer_of(R"({"x": 1, "y": "2", "radius_m": 3})"), "/near/y");
  EXPECT_EQ(pointer_of(R"({"x": 1, "y": 2})"), "/near/radius_m");
  EXPECT_EQ(pointer_of(R"({"x": 1, "y": 2, "radius_m": 0})"), "/near/radius_m");
  EXPECT_EQ(pointer_of(R"({"x": 1, "y": 2, "radius_m": 3, "map": 7})"), "/near/map");
  EXPECT_EQ(pointer_of(R"({"x": 1, "y": 2, "radius_m": 3, "yaw": "east"})"), "/near/yaw");
  EXPECT_EQ(pointer_of(R"({"x": 1, "y": 2, "radius_m": 3, "yaw": 0, "yaw_tolerance_rad": 4})"),
            "/near/yaw_tolerance_rad");
  EXPECT_EQ(pointer_of(R"({"x": 1, "y": 2, "radius_m": 3, "yaw_tolerance_rad": 1})"),
            "/near/yaw_tolerance_rad");
  EXPECT_EQ(pointer_of(R"({"x": 1, "y": 2, "radius_m": 3, "z": 0})"), "/near/z");
}

TEST(Reset, TakesWhereTheRobotIsNowOrNothing) {
  EXPECT_FALSE(taken(parse_reset("{}", BodyFormat::kJson)).region.has_value());
  EXPECT_EQ(
      taken(parse_reset(R"({"near": {"x": 1, "y": 2, "radius_m": 3}})", BodyFormat::kJson)).region,
      (StartRegion{.center = {1.0, 2.0}, .radius_m = 3.0}));
  const auto unknown = parse_reset(R"({"pose": {}})", BodyFormat::kJson);
  EXPECT_EQ(std::get<Problem>(unknown).errors.front().pointer, "/pose");
}

// --- Several lidars

std::string lidars_text() {
  return std::string(R"({"front": )") + kLidarText + R"(, "rear": {
      "angle_min": 0, "angle_increment": 0.1, "range_min": 0, "range_max": 5,
      "mount": {"x": -0.2, "y": 0, "yaw": 3, "roll": 3.1415926, "pitch": 0.1}}})";
}

Parsed<CreateSessionRequest> session_with_lidars(const std::string& lidars) {
  return parse_create_session(R"({"robot": "r2", "lidars": )" + lidars + "}", BodyFormat::kJson);
}

TEST(CreateSession, TakesSeveralLidarsOrNone) {
  const auto request = taken(session_with_lidars(lidars_text()));
  ASSERT_EQ(request.lidars.by_name.size(), 2U);
  EXPECT_FALSE(request.lidars.only.has_value());
  EXPECT_EQ(request.lidars.by_name.at("rear").T_base_link_laser, (Pose2{-0.2, 0.0, 3.0}));
  EXPECT_EQ(request.lidars.by_name.at("rear").tilt, (LidarTilt{.roll = 3.1415926, .pitch = 0.1}));
  EXPECT_EQ(lidars_from_json(request.lidar_json), request.lidars);
  const auto none = taken(parse_create_session(R"({"robot": "r2"})", BodyFormat::kJson));
  EXPECT_EQ(none.lidars, Lidars());
  EXPECT_EQ(lidars_from_json(none.lidar_json), Lidars());
  EXPECT_FALSE(lidars_from_json(R"({"lidars": {"front": {}}})").has_value());
}

TEST(CreateSession, SaysWhichOfTheLidarsIsWrong) {
  const auto pointer_of = [](const std::string& lidars) {
    const auto parsed = session_with_lidars(lidars);
    const auto* problem = std::get_if<Problem>(&parsed);
    return problem == nullptr ? "no error" : problem->errors.front().pointer;
  };
  EXPECT_EQ(pointer_of("[]"), "/lidars");
  EXPECT_EQ(pointer_of("{}"), "/lidars");
  EXPECT_EQ(pointer_of(R"({"front": null})"), "/lidars/front");
  EXPECT_EQ(pointer_of(R"({"front": 5})"), "/lidars/front");
  EXPECT_EQ(pointer_of(R"({"front": {"angle_min": "x"}})"), "/lidars/front/angle_min");
  EXPECT_EQ(pointer_of(std::string(R"({"../x": )") + kLidarText + "}"), "/lidars/..~1x");
}

Parsed<SessionScansRequest> scans_of_two(const std::string& scans) {
  const Lidars lidars = taken(session_with_lidars(lidars_text())).lidars;
  return parse_session_scans(session_batch(scans), BodyFormat::kJson, lidars, {});
}

TEST(SessionScans, OfSeveralLidarsHaveTheirGeometryAndTheOrderOfTheirStamps) {
  const auto request = taken(scans_of_two(R"({"stamp": 1.1, "lidar": "front", "ranges": [1, 2, 3]},
                            {"stamp": 1.3, "lidar": "front", "ranges": [1, 2, 3]},
                            {"stamp": 1.1, "lidar": "rear", "ranges": [1, 2]})"));
  ASSERT_EQ(request.scans.size(), 3U);
  EXPECT_EQ(request.scans[0].scan.angle_min, -1.0);
  EXPECT_EQ(request.scans[1].scan.stamp, 1.1);
  EXPECT_EQ(request.scans[1].T_base_link_laser, (Pose2{-0.2, 0.0, 3.0}));
  EXPECT_LT(request.scans[1].scan.angle_increment, 0.0) << "it hangs upside down";
  EXPECT_EQ(request.scans[2].scan.stamp, 1.3);
}

TEST(SessionScans, OfSeveralLidarsNameOneOfThem) {
  const auto error_of = [](const std::string& scans) {
    const auto parsed = scans_of_two(scans);
    const auto* problem = std::get_if<Problem>(&parsed);
    return problem == nullptr ? FieldError{} : problem->errors.front();
  };
  EXPECT_EQ(error_of(R"({"stamp": 1, "ranges": [1]})").pointer, "/scans/0/lidar");
  const FieldError unknown = error_of(R"({"stamp": 1, "lidar": "left", "ranges": [1]})");
  EXPECT_EQ(unknown.pointer, "/scans/0/lidar");
  EXPECT_EQ(unknown.detail, "must be a lidar of the session: front, rear");
  EXPECT_EQ(error_of(R"({"stamp": 2, "lidar": "rear", "ranges": [1]},
                        {"stamp": 3, "lidar": "front", "ranges": [1]},
                        {"stamp": 2, "lidar": "rear", "ranges": [1]})")
                .pointer,
            "/scans/2/stamp");
}

TEST(SessionScans, NeedNoLidarWhenEachBringsItsGeometry) {
  const auto request = taken(parse_session_scans(
      session_batch(R"({"stamp": 1, "angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                        "range_max": 5, "ranges": [1, 2],
                        "mount": {"x": 0.3, "y": 0, "yaw": 0, "roll": 3.1415926}})"),
      BodyFormat::kJson, Lidars(), {}));
  ASSERT_EQ(request.scans.size(), 1U);
  EXPECT_EQ(request.scans[0].T_base_link_laser, (Pose2{0.3, 0.0, 0.0}));
  EXPECT_LT(request.scans[0].scan.angle_increment, 0.0);
  const auto parsed = parse_session_scans(session_batch(R"({"stamp": 1, "ranges": [1, 2]})"),
                                          BodyFormat::kJson, Lidars(), {});
  EXPECT_EQ(std::get<Problem>(parsed).errors.front().pointer, "/lidar");
}

TEST(Localize, TakesScansAndOptions) {
  const auto request = taken(parse_localize(
      std::string(R"({"lidar": )") + kLidarText +
          R"(, "options": {"seed": 5}, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})",
      BodyFormat::kJson, {}));
  EXPECT_EQ(request.scans.size(), 1U);
  EXPECT_EQ(request.params.seed, 5U);
}

TEST(Trajectory, TakesStampedPosesInAnyOrder) {
  const auto request = taken(parse_trajectory(
      R"({"poses": [{"stamp": 2, "x": 1, "y": 2, "yaw": 7}, {"stamp": 1, "x": 0, "y": 0,
          "yaw": 0}]})",
      BodyFormat::kJson));
  ASSERT_EQ(request.poses.size(), 2U);
  EXPECT_EQ(request.poses[0].stamp, 2.0);
  EXPECT_EQ(request.poses[0].T_map_base_link, (Pose2{1.0, 2.0, wrap_angle(7.0)}));
}

TEST(MergedParameters, KeepWhatIsNotGiven) {
  EXPECT_EQ(merged_parameters("", R"({"extractor": "vfp"})").value(), R"({"extractor":"vfp"})");
  EXPECT_EQ(merged_parameters(R"({"extractor": "vfp", "grid": {"max_range_m": 9}})",
                              R"({"grid": {"resolution_m": 0.1}, "extractor": null})")
                .value(),
            R"({"extractor":"vfp","grid":{"max_range_m":9,"resolution_m":0.1}})");
}

TEST(MergedParameters, AreRefusedWhenTheyDoNotGoTogether) {
  const auto merged = merged_parameters(R"({"descriptors": {"distance_resolution_m": 0.01}})",
                                        R"({"descriptors": {"max_distance_m": 1000}})");
  ASSERT_FALSE(merged);
  EXPECT_EQ(merged.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(merged.error().field, ::testing::StartsWith("/parameters/descriptors/"));
}

TEST(Bbox, IsTwoOppositeCorners) {
  const auto box = taken(parse_bbox("5,-1,2.5,3"));
  EXPECT_EQ(box.min, Point2(2.5, -1.0));
  EXPECT_EQ(box.max, Point2(5.0, 3.0));
}

TEST(Bbox, IsRefusedWhenItIsNotFourNumbers) {
  for (const char* text : {"", "1", "1,2,3", "1,2,3,4,5", "1,2,3,", ",1,2,3", "1,2,3,4,", "a,2,3,4",
                           "1,2,3,nan", "1,2,3,inf", "1,2,3,4 ", "1;2;3;4"}) {
    const auto parsed = parse_bbox(text);
    const auto* problem = std::get_if<Problem>(&parsed);
    ASSERT_NE(problem, nullptr) << text;
    EXPECT_EQ(problem->status, 422) << text;
  }
}

TEST(PageLimit, IsOneToAThousand) {
  EXPECT_EQ(taken(parse_page_limit("1")), 1U);
  EXPECT_EQ(taken(parse_page_limit("1000")), 1000U);
  for (const char* text : {"", "0", "1001", "-1", "1.5", "ten", "99999999999999999999"}) {
    EXPECT_TRUE(std::holds_alternative<Problem>(parse_page_limit(text))) << text;
  }
}

TEST(Name, FollowsTheContractsPattern) {
  EXPECT_TRUE(is_valid_name("office-2"));
  EXPECT_TRUE(is_valid_name("0"));
  EXPECT_TRUE(is_valid_name("a._-Z9"));
  EXPECT_TRUE(is_valid_name(std::string(128, 'a')));
  for (const std::string name : {"", ".a", "-a", "_a", "a b", "a/b", "ä", "a%20"}) {
    EXPECT_FALSE(is_valid_name(name)) << name;
  }
  EXPECT_FALSE(is_valid_name(std::string(129, 'a')));
  EXPECT_FALSE(is_valid_name(std::string("a\0b", 3)));
}

}  // namespace
}  // namespace cornerfix::api

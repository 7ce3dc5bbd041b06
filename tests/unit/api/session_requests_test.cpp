#include "api/requests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "unit/api/scan_text.hpp"
#include "unit/api/taken.hpp"

namespace cornerfix::api {
namespace {

using ::testing::ElementsAre;

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
  EXPECT_EQ(request.params.paper.min_votes, LocalizerParams{}.paper.min_votes);
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

TEST(CreateSession, TakesSeveralLidarsOrNone) {
  const auto request = taken(session_with_lidars(lidars_text()));
  ASSERT_EQ(request.lidars.by_name.size(), 2U);
  EXPECT_FALSE(request.lidars.only.has_value());
  EXPECT_EQ(request.lidars.by_name.at("rear").T_base_link_laser, (Pose2{-0.2, 0.0, 3.0}));
  EXPECT_EQ(request.lidars.by_name.at("rear").tilt, (LidarTilt{.roll = 3.1415926, .pitch = 0.1}));
  EXPECT_EQ(lidars_from_json(lidars_to_json(request.lidars)), request.lidars);
  const auto none = taken(parse_create_session(R"({"robot": "r2"})", BodyFormat::kJson));
  EXPECT_EQ(none.lidars, Lidars());
  EXPECT_EQ(lidars_from_json(lidars_to_json(none.lidars)), Lidars());
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

TEST(Localize, TakesScansAndOptions) {
  const auto request = taken(parse_localize(
      std::string(R"({"lidar": )") + kLidarText +
          R"(, "options": {"seed": 5}, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})",
      BodyFormat::kJson, {}));
  EXPECT_EQ(request.scans.size(), 1U);
  EXPECT_EQ(request.params.seed, 5U);
}

}  // namespace
}  // namespace cornerfix::api

#include "unit/api/refused_body.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace cornerfix::api {
namespace {

class NewSession : public ::testing::TestWithParam<Case> {};

TEST_P(NewSession, IsRefused) {
  expect_problem(parse_create_session(GetParam().body, BodyFormat::kJson), GetParam().status,
                 GetParam().pointer);
}

/// The body has these members beside robot and lidar.
class MembersOfASession : public ::testing::TestWithParam<Case> {};

std::string session(const std::string& members) {
  return std::string(R"({"robot": "r2", "lidar": )") + kLidarText + ", " + members + "}";
}

TEST_P(MembersOfASession, AreRefused) {
  expect_problem(parse_create_session(session(GetParam().body), BodyFormat::kJson),
                 GetParam().status, GetParam().pointer);
}

/// The body's lidar has these members.
class LidarOfASession : public ::testing::TestWithParam<Case> {};

TEST_P(LidarOfASession, IsRefused) {
  const std::string body = std::string(R"({"robot": "r2", "lidar": {)") + GetParam().body + "}}";
  expect_problem(parse_create_session(body, BodyFormat::kJson), GetParam().status,
                 GetParam().pointer);
}

constexpr Case kWrongSessions[] = {
    {"NoRobot",
     R"({"lidar": {"angle_min": -1.0, "angle_increment": 0.5, "range_min": 0.1,
          "range_max": 10.0}})",
     422, "/robot"},
    {"RobotEmpty",
     R"({"robot": "", "lidar": {"angle_min": -1.0, "angle_increment": 0.5, "range_min": 0.1,
          "range_max": 10.0}})",
     422, "/robot"},
    {"RobotWithASlash",
     R"({"robot": "a/b", "lidar": {"angle_min": -1.0, "angle_increment": 0.5, "range_min": 0.1,
          "range_max": 10.0}})",
     422, "/robot"},
    {"RobotANumber",
     R"({"robot": 2, "lidar": {"angle_min": -1.0, "angle_increment": 0.5, "range_min": 0.1,
          "range_max": 10.0}})",
     422, "/robot"},
};
INSTANTIATE_TEST_SUITE_P(Wrong, NewSession, ::testing::ValuesIn(kWrongSessions), case_name);

constexpr Case kWrongMembers[] = {
    {"MapANumber", R"("map": 3)", 422, "/map"},
    {"MapsAString", R"("maps": "a")", 422, "/maps"},
    {"MapsEmpty", R"("maps": [])", 422, "/maps"},
    {"MapsWithAWrongName", R"("maps": ["a", ".b"])", 422, "/maps/1"},
    {"MapAndMaps", R"("map": "a", "maps": ["b"])", 422, "/maps"},
    {"LidarAndLidars", R"("lidars": {})", 422, "/lidars"},
    {"OptionsAList", R"("options": [])", 422, "/options"},
    {"UnknownOption", R"("options": {"sede": 2})", 422, "/options/sede"},
    {"UnknownOptionWithASlash", R"("options": {"a/b~c": 2})", 422, "/options/a~1b~0c"},
    {"UnknownNestedOption", R"("options": {"acceptance": {"p": 2}})", 422, "/options/acceptance/p"},
    {"UnknownMethod", R"("options": {"method": "sift"})", 422, "/options/method"},
    {"UnknownExtractor", R"("options": {"extractor": "sift"})", 422, "/options/extractor"},
    {"MethodANumber", R"("options": {"method": 1})", 422, "/options/method"},
    {"SeedNegative", R"("options": {"seed": -1})", 422, "/options/seed"},
    {"UnknownMemberOfASession", R"("initial_pose": {"x": 0, "y": 0, "yaw": 0})", 422,
     "/initial_pose"},
    {"OptionOutOfRange", R"("options": {"min_features": 0})", 422, "/options/min_features"},
    {"OptionAboveInt", R"("options": {"min_votes": 4294967297})", 422, "/options/min_votes"},
    {"NestedOptionOutOfRange", R"("options": {"acceptance": {"min_probability": 1.5}})", 422,
     "/options/acceptance/min_probability"},
};
INSTANTIATE_TEST_SUITE_P(Wrong, MembersOfASession, ::testing::ValuesIn(kWrongMembers), case_name);

constexpr Case kWrongLidars[] = {
    {"LidarWithoutMembers", "", 422, "/lidar/angle_min"},
    {"LidarWithoutRangeMax", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0)", 422,
     "/lidar/range_max"},
    {"LidarIncrementZero",
     R"("angle_min": 0, "angle_increment": 0, "range_min": 0, "range_max": 9)", 422,
     "/lidar/angle_increment"},
    {"LidarRangeMinNegative",
     R"("angle_min": 0, "angle_increment": 0.1, "range_min": -1, "range_max": 9)", 422,
     "/lidar/range_min"},
    {"LidarBeamsZero", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "beams": 0)",
     422, "/lidar/beams"},
    {"LidarBeamsHuge", R"("angle_min": 0, "angle_increment": 1e-300, "range_min": 0,
                                   "range_max": 9, "beams": 1000000000000)",
     422, "/lidar/beams"},
    {"LidarOfTwoTurns", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "beams": 130)",
     422, "/lidar/beams"},
    {"LidarWithAnUnknownMember", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "roll": 3.14)",
     422, "/lidar/roll"},
    {"LidarTooFarRolled", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9,
                                   "mount": {"x": 0, "y": 0, "yaw": 0, "roll": 0.3})",
     422, "/lidar/mount/roll"},
    {"LidarTooFarPitched", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9,
                                   "mount": {"x": 0, "y": 0, "yaw": 0, "pitch": 3.14})",
     422, "/lidar/mount/pitch"},
    {"LidarOfAMinutePerScan", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "beams": 60, "time_increment": 0.5)",
     422, "/lidar/time_increment"},
    {"LidarOfASecondPerBeam", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "time_increment": 1)",
     422, "/lidar/time_increment"},
    {"LidarMountInMillimetres", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "mount": {"x": 250, "y": 0, "yaw": 0})",
     422, "/lidar/mount/x"},
    {"LidarMountInDegrees", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "mount": {"x": 0, "y": 0, "yaw": 180})",
     422, "/lidar/mount/yaw"},
    {"LidarMountWithoutYaw", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "mount": {"x": 0, "y": 0})",
     422, "/lidar/mount/yaw"},
};
INSTANTIATE_TEST_SUITE_P(Wrong, LidarOfASession, ::testing::ValuesIn(kWrongLidars), case_name);

class NewMap : public ::testing::TestWithParam<Case> {};

TEST_P(NewMap, IsRefused) {
  expect_problem(parse_put_map(GetParam().body, BodyFormat::kJson), GetParam().status,
                 GetParam().pointer);
}

constexpr Case kWrongMaps[] = {
    {"Empty", "", 400},
    {"DescriptionANumber", R"({"description": 1})", 422, "/description"},
    {"LidarEmpty", R"({"lidar": {}})", 422, "/lidar/range_min"},
    {"UnknownMemberOfAMap", R"({"beschreibung": ""})", 422, "/beschreibung"},
    {"UnknownParameter", R"({"parameters": {"resolution": 1}})", 422, "/parameters/resolution"},
    {"UnknownNestedParameter", R"({"parameters": {"grid": {"cell": 1}}})", 422,
     "/parameters/grid/cell"},
    {"NestedParameterANumber", R"({"parameters": {"grid": 1}})", 422, "/parameters/grid"},
    {"ParameterOutOfRange", R"({"parameters": {"grid": {"resolution_m": 0}}})", 422,
     "/parameters/grid/resolution_m"},
    {"ParameterAString", R"({"parameters": {"min_feature_count": "2"}})", 422,
     "/parameters/min_feature_count"},
    {"ParameterFractional", R"({"parameters": {"min_feature_count": 2.5}})", 422,
     "/parameters/min_feature_count"},
};
INSTANTIATE_TEST_SUITE_P(Wrong, NewMap, ::testing::ValuesIn(kWrongMaps), case_name);

TEST(DescriptionOfAMap, MustNotBeLong) {
  const std::string body = R"({"description": ")" + std::string(5000, 'a') + R"("})";
  expect_problem(parse_put_map(body, BodyFormat::kJson), 422, "/description");
}

class Trajectory : public ::testing::TestWithParam<Case> {};

TEST_P(Trajectory, IsRefused) {
  expect_problem(parse_trajectory(GetParam().body, BodyFormat::kJson), GetParam().status,
                 GetParam().pointer);
}

constexpr Case kWrongTrajectories[] = {
    {"NoPoses", "{}", 422, "/poses"},
    {"EmptyPoses", R"({"poses": []})", 422, "/poses"},
    {"PosesAnObject", R"({"poses": {}})", 422, "/poses"},
    {"PoseAnArray", R"({"poses": [[1, 2, 3, 4]]})", 422, "/poses/0"},
    {"NoStamp", R"({"poses": [{"x": 0, "y": 0, "yaw": 0}]})", 422, "/poses/0/stamp"},
    {"NoYaw", R"({"poses": [{"stamp": 1, "x": 0, "y": 0}]})", 422, "/poses/0/yaw"},
};
INSTANTIATE_TEST_SUITE_P(Wrong, Trajectory, ::testing::ValuesIn(kWrongTrajectories), case_name);

class Question : public ::testing::TestWithParam<Case> {};

TEST_P(Question, IsRefused) {
  expect_problem(parse_localize(GetParam().body, BodyFormat::kJson, {}), GetParam().status,
                 GetParam().pointer);
}

constexpr Case kWrongQuestions[] = {
    {"NoLidar", R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})", 422, "/lidar"},
    {"ScanWithHalfAGeometry", R"({"scans": [{"stamp": 1, "ranges": [1], "angle_min": 0}]})", 422,
     "/scans/0/range_max"},
    {"UnknownOption",
     R"({"lidar": {"angle_min": -1.0, "angle_increment": 0.5, "range_min": 0.1,
          "range_max": 10.0}, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}], "options": {"x": 1}})",
     422, "/options/x"},
};
INSTANTIATE_TEST_SUITE_P(Wrong, Question, ::testing::ValuesIn(kWrongQuestions), case_name);

// --- Binary formats -------------------------------------------------------------------------

struct BinaryCase {
  const char* name;
  BodyFormat format;
  std::string body;
};

void PrintTo(const BinaryCase& c, std::ostream* os) { *os << c.name; }

class BinaryBody : public ::testing::TestWithParam<BinaryCase> {};

TEST_P(BinaryBody, IsRefusedAsUnparsable) {
  expect_problem(parse_session_scans(GetParam().body, GetParam().format, three_beam_lidar(), {}),
                 400);
}

std::string half_of(const std::string& body) { return body.substr(0, body.size() / 2); }

std::string encoded_batch(BodyFormat format) {
  return encode_as(nlohmann::json::parse(session_batch(kScan)), format);
}

std::vector<BinaryCase> broken_bodies() {
  std::vector<BinaryCase> cases;
  const auto add = [&](const char* name, BodyFormat format, const std::string& body) {
    cases.push_back({name, format, body});
  };
  add("CborEmpty", BodyFormat::kCbor, "");
  add("CborTruncated", BodyFormat::kCbor, half_of(encoded_batch(BodyFormat::kCbor)));
  add("CborTrailing", BodyFormat::kCbor, encoded_batch(BodyFormat::kCbor) + "\x01");
  add("CborThatIsJson", BodyFormat::kCbor, session_batch(kScan));
  add("CborDeepArrays", BodyFormat::kCbor, std::string(1'000'000, '\x81'));
  add("CborDeepIndefiniteArrays", BodyFormat::kCbor, std::string(1'000'000, '\x9f'));
  add("CborDeepMaps", BodyFormat::kCbor, repeat("\xa1\x61x", 100'000));
  add("CborDeepTags", BodyFormat::kCbor, std::string(1'000'000, '\xc1'));
  add("CborDeepIndefiniteText", BodyFormat::kCbor, std::string(1'000'000, '\x7f'));
  add("CborDeepIndefiniteKey", BodyFormat::kCbor, "\xa1" + std::string(1'000'000, '\x7f'));
  add("CborDeepIndefiniteBytes", BodyFormat::kCbor, std::string(1'000'000, '\x5f'));
  add("CborDeepTextWithEmptyChunks", BodyFormat::kCbor, repeat("\x7f\x60", 500'000));
  add("CborHugeArrayClaimed", BodyFormat::kCbor,
      std::string("\x9b\x00\xff\xff\xff\xff\xff\xff\xff", 9));
  add("CborHugeTextClaimed", BodyFormat::kCbor,
      std::string("\x7b\x00\xff\xff\xff\xff\xff\xff\xff", 9));
  add("CborNumberAsKey", BodyFormat::kCbor, "\xa1\x01\x02");
  add("CborBadUtf8Value", BodyFormat::kCbor, "\xa1\x61x\x62\xff\xfe");
  add("CborBadUtf8Key", BodyFormat::kCbor, "\xa1\x62\xff\xfe\x01");
  add("CborDuplicateKey", BodyFormat::kCbor, "\xa2\x61x\x01\x61x\x02");
  add("MessagePackEmpty", BodyFormat::kMessagePack, "");
  add("MessagePackTruncated", BodyFormat::kMessagePack,
      half_of(encoded_batch(BodyFormat::kMessagePack)));
  add("MessagePackTrailing", BodyFormat::kMessagePack,
      encoded_batch(BodyFormat::kMessagePack) + "\x01");
  add("MessagePackDeepArrays", BodyFormat::kMessagePack, std::string(1'000'000, '\x91'));
  add("MessagePackDeepMaps", BodyFormat::kMessagePack, repeat("\x81\xa1x", 100'000));
  add("MessagePackHugeArrayClaimed", BodyFormat::kMessagePack, "\xdd\xff\xff\xff\xff");
  add("MessagePackBadUtf8Value", BodyFormat::kMessagePack, "\x81\xa1x\xa2\xff\xfe");
  add("MessagePackNeverUsedByte", BodyFormat::kMessagePack, "\xc1");
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Broken, BinaryBody, ::testing::ValuesIn(broken_bodies()),
                         [](const ::testing::TestParamInfo<BinaryCase>& tested) {
                           return std::string(tested.param.name);
                         });

TEST(BinaryBody, IsNamedForWhatCannotBeRead) {
  const auto detail_of = [](const std::string& body, BodyFormat format) {
    return std::get<Problem>(parse_put_map(body, format)).detail;
  };
  EXPECT_EQ(detail_of("\xa1\x61x\xf7", BodyFormat::kCbor),
            "The body cannot be read from byte 4: CBOR value: invalid byte: 0xF7, where tags and "
            "undefined are not read.");
  EXPECT_EQ(detail_of("\xa1\x61x", BodyFormat::kCbor),
            "The body cannot be read from byte 4: CBOR value: unexpected end of input.");
  EXPECT_EQ(detail_of("\xc1", BodyFormat::kMessagePack),
            "The body cannot be read from byte 1: MessagePack value: invalid byte: 0xC1.");
}

TEST(BinaryRoot, MustBeAnObject) {
  for (const BodyFormat format : {BodyFormat::kCbor, BodyFormat::kMessagePack}) {
    expect_problem(parse_put_map(encode_as(nlohmann::json::array(), format), format), 422);
    expect_problem(parse_put_map(encode_as(nlohmann::json(1), format), format), 422);
  }
}

TEST(BinaryRange, MustNotBeAByteString) {
  nlohmann::json batch = nlohmann::json::parse(session_batch(kScan));
  batch["scans"][0]["ranges"] = nlohmann::json::binary({0, 0, 0});
  for (const BodyFormat format : {BodyFormat::kCbor, BodyFormat::kMessagePack}) {
    expect_problem(parse_session_scans(encode_as(batch, format), format, three_beam_lidar(), {}),
                   422, "/scans/0/ranges");
  }
}

TEST(ManyErrors, AreListedUpToTwenty) {
  const std::string body =
      session_batch(R"({"stamp": 1, "ranges": [)" + repeat("\"x\", ", 49) + "\"x\"]}");
  Lidar lidar = three_beam_lidar();
  lidar.beams.reset();
  lidar.angle_increment = 0.01;
  const auto parsed = parse_session_scans(body, BodyFormat::kJson, lidar, {});
  const auto& problem = std::get<Problem>(parsed);
  EXPECT_EQ(problem.status, 422);
  EXPECT_EQ(problem.errors.size(), 20U);
}

TEST(UnknownOption, TellsTheKnownOnes) {
  const auto parsed = parse_create_session(session(R"("options": {"x": 1})"), BodyFormat::kJson);
  const auto& problem = std::get<Problem>(parsed);
  EXPECT_NE(problem.detail.find("method, extractor"), std::string::npos) << problem.detail;
}

}  // namespace
}  // namespace cornerfix::api

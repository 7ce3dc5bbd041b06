// Bodies by table: each gets its status, and where one member is wrong, its pointer.
//
// The tables are literals: temporary strings would make this file take minutes to compile.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "api/requests.hpp"
#include "unit/api/scan_text.hpp"

namespace cornerfix::api {
namespace {

struct Case {
  const char* name;
  const char* body;  ///< Or a part of it, see the fixture.
  int status;
  const char* pointer = nullptr;  ///< Of one of the errors.
};

void PrintTo(const Case& c, std::ostream* os) { *os << c.name << ": " << c.body; }

std::string case_name(const testing::TestParamInfo<Case>& tested) { return tested.param.name; }

bool points_at(const Problem& problem, const std::string& pointer) {
  return std::any_of(problem.errors.begin(), problem.errors.end(),
                     [&](const FieldError& error) { return error.pointer == pointer; });
}

template <typename Request>
void expect_problem(const Parsed<Request>& parsed, int status, const char* pointer = nullptr) {
  const auto* problem = std::get_if<Problem>(&parsed);
  ASSERT_NE(problem, nullptr) << "was taken";
  EXPECT_EQ(problem->status, status) << render(*problem);
  EXPECT_FALSE(problem->detail.empty());
  if (pointer != nullptr) {
    EXPECT_TRUE(points_at(*problem, pointer)) << render(*problem);
  }
}

std::string repeat(const std::string& text, std::size_t times) {
  std::string out;
  for (std::size_t i = 0; i < times; ++i) out += text;
  return out;
}

const std::string kScan = R"({"stamp": 1, "ranges": [1, 2, 3]})";

Parsed<SessionScansRequest> parse_batch(const std::string& body) {
  return parse_session_scans(body, BodyFormat::kJson, three_beam_lidar(), {});
}

// --- A batch of a session -------------------------------------------------------------------

class SessionBatch : public testing::TestWithParam<Case> {};

TEST_P(SessionBatch, IsRefused) {
  expect_problem(parse_batch(GetParam().body), GetParam().status, GetParam().pointer);
}

/// The body has one batch of these scans.
class ScansOfABatch : public testing::TestWithParam<Case> {};

TEST_P(ScansOfABatch, AreRefused) {
  expect_problem(parse_batch(session_batch(GetParam().body)), GetParam().status,
                 GetParam().pointer);
}

constexpr Case kUnparsableBatches[] = {
    {"Empty", "", 400},
    {"Blank", "  \n", 400},
    {"Text", "hello", 400},
    {"HalfAnAtom", "nul", 400},
    {"Form", "sequence=1&scans=2", 400},
    {"Truncated", R"({"sequence": 0, "scans": [{"stamp": 1, "ranges": [1, 2)", 400},
    {"TruncatedInAString", R"({"sequence": 0, "sca)", 400},
    {"TruncatedBeforeTheEnd", R"({"sequence": 0, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}])",
     400},
    {"TrailingComma", R"({"sequence": 0, "scans": [{"stamp": 1, "ranges": [1, 2, 3]},]})", 400},
    {"TrailingContent", R"({"sequence": 0, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]} 1)", 400},
    {"TwoDocuments",
     R"({"sequence": 0, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]}{"sequence": 0,
          "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})",
     400},
    {"MissingComma", R"({"sequence": 0 "scans": []})", 400},
    {"MissingColon", R"({"sequence" 0})", 400},
    {"SingleQuotes", "{'sequence': 0}", 400},
    {"UnquotedName", "{sequence: 0}", 400},
    {"Comment", "{} // batch", 400},
    {"InvalidUtf8", "{\"sequence\": 0, \"note\": \"\xff\xfe\", \"scans\": []}", 400},
    {"OverlongUtf8", "{\"sequence\": 0, \"note\": \"\xc0\xaf\", \"scans\": []}", 400},
    {"LoneSurrogate", R"({"sequence": 0, "note": "\ud800", "scans": []})", 400},
    {"ControlCharacter", "{\"sequence\": 0, \"note\": \"a\nb\"}", 400},
    {"BadEscape", R"({"sequence": 0, "note": "\x"})", 400},
    {"ByteOrderMarkAlone", "\xEF\xBB\xBF", 400},
    {"DuplicateMember", R"({"sequence": 0, "sequence": 1, "scans": []})", 400},
    {"DuplicateScans",
     R"({"sequence": 0, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}], "scans": [{"stamp": 1,
          "ranges": [1, 2, 3]}]})",
     400},
};
INSTANTIATE_TEST_SUITE_P(Unparsable, SessionBatch, testing::ValuesIn(kUnparsableBatches),
                         case_name);

constexpr Case kUnparsableScans[] = {
    {"NaNLiteral", R"({"stamp": 1, "ranges": [1, NaN, 3]})", 400},
    {"InfinityLiteral", R"({"stamp": 1, "ranges": [1, Infinity, 3]})", 400},
    {"LeadingZero", R"({"stamp": 01, "ranges": [1, 2, 3]})", 400},
    {"PlusSign", R"({"stamp": +1, "ranges": [1, 2, 3]})", 400},
    {"LoneMinus", R"({"stamp": 1, "ranges": [1, -, 3]})", 400},
    {"DotWithoutDigits", R"({"stamp": 1, "ranges": [1, 2., 3]})", 400},
    {"BrokenRange", R"({"stamp": 1, "ranges": [1, 2x, 3]})", 400},
    {"BrokenIntensity", R"({"stamp": 1, "ranges": [1, 2, 3], "intensities": [1, tru]})", 400},
    {"BrokenUnknownMember", R"({"stamp": 1, "ranges": [1, 2, 3], "x": [nil]})", 400},
    {"DuplicateRanges", R"({"stamp": 1, "ranges": [1], "ranges": [2]})", 400},
};
INSTANTIATE_TEST_SUITE_P(Unparsable, ScansOfABatch, testing::ValuesIn(kUnparsableScans), case_name);

constexpr Case kNoObject[] = {
    {"Array", R"([{"stamp": 1, "ranges": [1, 2, 3]}])", 422},
    {"EmptyArray", "[]", 422},
    {"Number", "17", 422},
    {"String", R"("scan")", 422},
    {"Null", "null", 422},
    {"True", "true", 422},
    {"NearlyTrue", "tru", 400},
    {"Word", "nonsense", 400},
};
INSTANTIATE_TEST_SUITE_P(NoObject, SessionBatch, testing::ValuesIn(kNoObject), case_name);

constexpr Case kWrongBatches[] = {
    {"NoMembers", "{}", 422, "/sequence"},
    {"UnknownMemberOfABatch",
     R"({"sequence": 0, "initial_pose": {}, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})", 422,
     "/initial_pose"},
    {"NoScans", R"({"sequence": 0})", 422, "/scans"},
    {"NullScans", R"({"sequence": 0, "scans": null})", 422, "/scans"},
    {"ScansAnObject", R"({"sequence": 0, "scans": {}})", 422, "/scans"},
    {"ScansAString", R"({"sequence": 0, "scans": "all"})", 422, "/scans"},
    {"NoSequence", R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})", 422, "/sequence"},
    {"NegativeSequence", R"({"sequence": -1, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})", 422,
     "/sequence"},
    {"FractionalSequence", R"({"sequence": 0.5, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})",
     422, "/sequence"},
    {"HugeStamp", R"({"sequence": 7, "scans": [{"stamp": 1e300, "ranges": [1, 2, 3]}]})", 422,
     "/scans/0/stamp"},
    {"EarlyStamp", R"({"sequence": 7, "scans": [{"stamp": -2e12, "ranges": [1, 2, 3]}]})", 422,
     "/scans/0/stamp"},
    {"HugeSequence", R"({"sequence": 1e300, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})", 422,
     "/sequence"},
    {"SequenceAboveInt64",
     R"({"sequence": 18446744073709551615, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})", 422,
     "/sequence"},
    {"SequenceAString", R"({"sequence": "0", "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})", 422,
     "/sequence"},
    {"SequenceABoolean", R"({"sequence": true, "scans": [{"stamp": 1, "ranges": [1, 2, 3]}]})", 422,
     "/sequence"},
};
INSTANTIATE_TEST_SUITE_P(WrongMember, SessionBatch, testing::ValuesIn(kWrongBatches), case_name);

constexpr Case kWrongScans[] = {
    {"EmptyScans", "", 422, "/scans"},
    {"ScanANumber", R"({"stamp": 1, "ranges": [1, 2, 3]}, 5)", 422, "/scans/1"},
    {"ScanNull", "null", 422, "/scans/0"},
    {"ScanAnArray", "[1, 2, 3]", 422, "/scans/0"},
    {"EmptyScan", "{}", 422, "/scans/0/ranges"},
    {"NoStamp", R"({"ranges": [1, 2, 3]})", 422, "/scans/0/stamp"},
    {"StampAString", R"({"stamp": "1", "ranges": [1, 2, 3]})", 422, "/scans/0/stamp"},
    {"StampInfinite", R"({"stamp": 1e999, "ranges": [1, 2, 3]})", 422, "/scans/0/stamp"},
    {"StampNull", R"({"stamp": null, "ranges": [1, 2, 3]})", 422, "/scans/0/stamp"},
    {"StampsEqual", R"({"stamp": 1, "ranges": [1, 2, 3]}, {"stamp": 1, "ranges": [1, 2, 3]})", 422,
     "/scans/1/stamp"},
    {"StampsFall", R"({"stamp": 1, "ranges": [1, 2, 3]}, {"stamp": 0.5, "ranges": [1, 2, 3]})", 422,
     "/scans/1/stamp"},
    {"NoRanges", R"({"stamp": 1})", 422, "/scans/0/ranges"},
    {"RangesNull", R"({"stamp": 1, "ranges": null})", 422, "/scans/0/ranges"},
    {"RangesAString", R"({"stamp": 1, "ranges": "1,2,3"})", 422, "/scans/0/ranges"},
    {"RangesAnObject", R"({"stamp": 1, "ranges": {"0": 1}})", 422, "/scans/0/ranges"},
    {"RangesANumber", R"({"stamp": 1, "ranges": 3})", 422, "/scans/0/ranges"},
    {"RangesEmpty", R"({"stamp": 1, "ranges": []})", 422, "/scans/0/ranges"},
    {"TooFewBeams", R"({"stamp": 1, "ranges": [1, 2]})", 422, "/scans/0/ranges"},
    {"TooManyBeams", R"({"stamp": 1, "ranges": [1, 2, 3]}, {"stamp": 2, "ranges": [1, 2, 3, 4]})",
     422, "/scans/1/ranges"},
    {"RangeAString", R"({"stamp": 1, "ranges": [1, "2", 3]})", 422, "/scans/0/ranges/1"},
    {"RangeABoolean", R"({"stamp": 1, "ranges": [1, 2, true]})", 422, "/scans/0/ranges/2"},
    {"RangeAnObject", R"({"stamp": 1, "ranges": [{"r": 1}, 2, 3]})", 422, "/scans/0/ranges/0"},
    {"RangeAnArray",
     R"({"stamp": 1, "ranges": [1, 2, 3]}, {"stamp": 2, "ranges": [1, [2, "x"], 3]})", 422,
     "/scans/1/ranges/1"},
    {"OdomAnArray", R"({"stamp": 1, "ranges": [1, 2, 3], "odom": [1, 2, 3]})", 422,
     "/scans/0/odom"},
    {"OdomWithoutYaw", R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 1, "y": 2}})", 422,
     "/scans/0/odom/yaw"},
    {"OdomNotFinite",
     R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 1e999, "y": 2, "yaw": 0}})", 422,
     "/scans/0/odom/x"},
    {"OdomOffTheEarth",
     R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 1, "y": -1e12, "yaw": 0}})", 422,
     "/scans/0/odom/y"},
    {"OdomYawNull", R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 1, "y": 2, "yaw": null}})",
     422, "/scans/0/odom/yaw"},
    {"HeaderWithoutStamp", R"({"header": {}, "ranges": [1, 2, 3]})", 422, "/scans/0/header/stamp"},
    {"HeaderAString", R"({"header": "h", "ranges": [1, 2, 3]})", 422, "/scans/0/header"},
    {"RosStampEmpty", R"({"header": {"stamp": {}}, "ranges": [1, 2, 3]})", 422,
     "/scans/0/header/stamp/sec"},
    {"RosStampWithManyNanoseconds", R"({"header": {"stamp": {"secs": 1, "nsecs": 1000000000}},
                               "ranges": [1, 2, 3]})",
     422, "/scans/0/header/stamp/nsecs"},
    {"OwnIncrementZero", R"({"stamp": 1, "ranges": [1, 2, 3], "angle_increment": 0})", 422,
     "/scans/0/angle_increment"},
    {"OwnRangesSwapped", R"({"stamp": 1, "ranges": [1, 2, 3], "range_min": 5, "range_max": 4})",
     422, "/scans/0/range_max"},
    {"OwnAngleAString", R"({"stamp": 1, "ranges": [1, 2, 3], "angle_min": "left"})", 422,
     "/scans/0/angle_min"},
    {"MoreThanATurn", R"({"stamp": 1, "ranges": [1, 2, 3], "angle_increment": 100})", 422,
     "/scans/0/angle_increment"},
    {"RangeMaxMinusInfinite", R"({"stamp": 1, "ranges": [1, 2, 3], "range_max": -1e999})", 422,
     "/scans/0/range_max"},
    {"UnknownMember", R"({"stamp": 1, "ranges": [1, 2, 3], "tilt": {"roll": 0}})", 422,
     "/scans/0/tilt"},
    {"LidarWithoutNamedLidars", R"({"stamp": 1, "ranges": [1, 2, 3], "lidar": "front"})", 422,
     "/scans/0/lidar"},
    {"MountWithoutYaw", R"({"stamp": 1, "ranges": [1, 2, 3], "mount": {"x": 0, "y": 0}})", 422,
     "/scans/0/mount/yaw"},
    {"PoseInASession", R"({"stamp": 1, "ranges": [1, 2, 3], "pose": {"x": 0, "y": 0, "yaw": 0}})",
     422, "/scans/0/pose"},
    {"UnknownMemberOfHeader", R"({"stamp": 1, "ranges": [1, 2, 3], "header": {"frame": "laser"}})",
     422, "/scans/0/header/frame"},
    {"UnknownMemberOfRosStamp",
     R"({"ranges": [1, 2, 3], "header": {"stamp": {"sec": 1, "nanoseconds": 5}}})", 422,
     "/scans/0/header/stamp/nanoseconds"},
    {"UnknownMemberOfOdom",
     R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 1, "y": 2, "yaw": 0, "z": 1}})", 422,
     "/scans/0/odom/z"},
    {"RosOdometryWithoutOrientation",
     R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"pose": {"pose": {"position": {}}}}})", 422,
     "/scans/0/odom/pose/pose/orientation"},
    {"RosOdometryOfNoRotation",
     R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"pose": {"pose": {
          "position": {"x": 0, "y": 0, "z": 0},
          "orientation": {"x": 0, "y": 0, "z": 0, "w": 0}}}}})",
     422, "/scans/0/odom/pose/pose/orientation"},
    {"RosOdometryOffTheEarth",
     R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"pose": {"pose": {
          "position": {"x": 1e12, "y": 0, "z": 0},
          "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}}}})",
     422, "/scans/0/odom/pose/pose/position"},
    {"UnknownMemberOfRosOdometry",
     R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"pose": {"pose": {
          "position": {"x": 0, "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}},
          "frame": "odom"}})",
     422, "/scans/0/odom/frame"},
};
INSTANTIATE_TEST_SUITE_P(WrongMember, ScansOfABatch, testing::ValuesIn(kWrongScans), case_name);

TEST(NulBytes, AreUnparsable) { expect_problem(parse_batch(std::string(64, '\0')), 400); }

TEST(DeepNesting, IsUnparsableWhereverItIs) {
  const std::string arrays = repeat("[", 100'000) + repeat("]", 100'000);
  expect_problem(parse_batch(R"({"x": )" + arrays + "}"), 400);
  expect_problem(parse_batch(arrays), 400);
  expect_problem(parse_batch(repeat("[", 100'000)), 400);
  expect_problem(parse_batch(session_batch(R"({"stamp": 1, "ranges": )" + arrays + "}")), 400);
  expect_problem(parse_batch(repeat(R"({"x": )", 2'000) + "1" + repeat("}", 2'000)), 400);
}

TEST(TooManyScans, AreTooLargeWhateverTheyHold) {
  expect_problem(parse_batch(session_batch(repeat(kScan + ", ", 100) + kScan)), 413, "/scans");
  expect_problem(parse_batch(session_batch(repeat("0, ", 100) + "0")), 413, "/scans");
}

TEST(TooManyBeams, AreTooLargeWhateverTheyHold) {
  const auto scan = [](const char* range) {
    return R"({"stamp": 1, "ranges": [)" + repeat(range + std::string(", "), 20'000) + range + "]}";
  };
  expect_problem(parse_batch(session_batch(scan("1"))), 413, "/scans/0/ranges");
  expect_problem(parse_batch(session_batch(kScan + ", " + scan("{}"))), 413, "/scans/1/ranges");
}

TEST(TooManyValues, AreTooLarge) {
  expect_problem(parse_batch(R"({"x": [)" + repeat("1, ", 600'000) + "1]}"), 413);
}

// --- Other requests -------------------------------------------------------------------------

class MapBatch : public testing::TestWithParam<Case> {};

TEST_P(MapBatch, IsRefused) {
  expect_problem(parse_map_scans(GetParam().body, BodyFormat::kJson, three_beam_lidar(), {}),
                 GetParam().status, GetParam().pointer);
}

constexpr Case kWrongMapBatches[] = {
    {"NoPose",
     R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3], "pose": {"x": 0, "y": 0, "yaw": 0}},
          {"stamp": 1, "ranges": [1, 2, 3]}]})",
     422, "/scans/1/pose"},
    {"PoseNullBesideAPose",
     R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3], "pose": null},
          {"stamp": 2, "ranges": [1, 2, 3], "pose": {"x": 0, "y": 0, "yaw": 0}}]})",
     422, "/scans/0/pose"},
    {"PoseWithoutYaw",
     R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3], "pose": {"x": 0, "y": 0}}]})", 422,
     "/scans/0/pose/yaw"},
    {"DriveWithOdomWithoutYaw",
     R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 0, "y": 0}}]})", 422,
     "/scans/0/odom/yaw"},
    {"DriveThatGoesBackInTime",
     R"({"scans": [{"stamp": 2, "ranges": [1, 2, 3]}, {"stamp": 1, "ranges": [1, 2, 3]}]})", 422,
     "/scans/1/stamp"},
    {"PoseNotFinite", R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3],
                            "pose": {"x": 0, "y": 0, "yaw": 1e999}}]})",
     422, "/scans/0/pose/yaw"},
    {"LidarAString",
     R"({"lidar": "hokuyo", "scans": [{"stamp": 1, "ranges": [1, 2, 3], "pose": {"x": 0, "y": 0,
          "yaw": 0}}]})",
     422, "/lidar"},
    {"LidarWithOtherBeams",
     R"({"lidar": {"angle_min": 0, "angle_increment": 1, "range_min": 0, "range_max": 1,
                           "beams": 2}, "scans": [{"stamp": 1, "ranges": [1, 2, 3],
          "pose": {"x": 0, "y": 0, "yaw": 0}}]})",
     422, "/scans/0/ranges"},
    {"UnknownMemberOfPose", R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3],
                            "pose": {"x": 0, "y": 0, "yaw": 0, "theta": 0}}]})",
     422, "/scans/0/pose/theta"},
    {"OtherBeamsOfTheSameLidar",
     R"({"lidar": {"angle_min": -1.0, "angle_increment": 0.5, "range_min": 0.1,
          "range_max": 10.0}, "scans": [{"stamp": 1, "ranges": [1], "pose": {"x": 0, "y": 0,
          "yaw": 0}}]})",
     422, "/scans/0/ranges"},
};
INSTANTIATE_TEST_SUITE_P(Wrong, MapBatch, testing::ValuesIn(kWrongMapBatches), case_name);

TEST(MapBatchWithoutLidar, IsRefusedWhenTheScansBringNone) {
  const std::string posed =
      R"({"stamp": 1, "ranges": [1, 2, 3], "pose": {"x": 0, "y": 0, "yaw": 0}})";
  expect_problem(parse_map_scans(R"({"scans": [)" + posed + "]}", BodyFormat::kJson, {}, {}), 422,
                 "/lidar");
}

class NewSession : public testing::TestWithParam<Case> {};

TEST_P(NewSession, IsRefused) {
  expect_problem(parse_create_session(GetParam().body, BodyFormat::kJson), GetParam().status,
                 GetParam().pointer);
}

/// The body has these members beside robot and lidar.
class MembersOfASession : public testing::TestWithParam<Case> {};

std::string session(const std::string& members) {
  return std::string(R"({"robot": "r2", "lidar": )") + kLidarText + ", " + members + "}";
}

TEST_P(MembersOfASession, AreRefused) {
  expect_problem(parse_create_session(session(GetParam().body), BodyFormat::kJson),
                 GetParam().status, GetParam().pointer);
}

/// The body's lidar has these members.
class LidarOfASession : public testing::TestWithParam<Case> {};

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
INSTANTIATE_TEST_SUITE_P(Wrong, NewSession, testing::ValuesIn(kWrongSessions), case_name);

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
INSTANTIATE_TEST_SUITE_P(Wrong, MembersOfASession, testing::ValuesIn(kWrongMembers), case_name);

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
    {"LidarMountWithoutYaw", R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "mount": {"x": 0, "y": 0})",
     422, "/lidar/mount/yaw"},
};
INSTANTIATE_TEST_SUITE_P(Wrong, LidarOfASession, testing::ValuesIn(kWrongLidars), case_name);

class NewMap : public testing::TestWithParam<Case> {};

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
INSTANTIATE_TEST_SUITE_P(Wrong, NewMap, testing::ValuesIn(kWrongMaps), case_name);

TEST(DescriptionOfAMap, MustNotBeLong) {
  const std::string body = R"({"description": ")" + std::string(5000, 'a') + R"("})";
  expect_problem(parse_put_map(body, BodyFormat::kJson), 422, "/description");
}

class Trajectory : public testing::TestWithParam<Case> {};

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
INSTANTIATE_TEST_SUITE_P(Wrong, Trajectory, testing::ValuesIn(kWrongTrajectories), case_name);

class Question : public testing::TestWithParam<Case> {};

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
INSTANTIATE_TEST_SUITE_P(Wrong, Question, testing::ValuesIn(kWrongQuestions), case_name);

// --- Binary formats -------------------------------------------------------------------------

struct BinaryCase {
  const char* name;
  BodyFormat format;
  std::string body;
};

void PrintTo(const BinaryCase& c, std::ostream* os) { *os << c.name; }

class BinaryBody : public testing::TestWithParam<BinaryCase> {};

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

INSTANTIATE_TEST_SUITE_P(Broken, BinaryBody, testing::ValuesIn(broken_bodies()),
                         [](const testing::TestParamInfo<BinaryCase>& tested) {
                           return std::string(tested.param.name);
                         });

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

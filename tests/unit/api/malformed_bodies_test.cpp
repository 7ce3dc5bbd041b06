// Bodies by table: each gets its status, and where one member is wrong, its pointer.
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
  std::string body;
  int status;
  const char* pointer = nullptr;  ///< Of one of the errors.
};

void PrintTo(const Case& c, std::ostream* os) { *os << c.name << ": " << c.body.substr(0, 300); }

std::string case_name(const testing::TestParamInfo<Case>& info) { return info.param.name; }

bool points_at(const Problem& problem, const std::string& pointer) {
  return std::any_of(problem.errors.begin(), problem.errors.end(),
                     [&](const FieldError& error) { return error.pointer == pointer; });
}

template <typename Request>
void expect_problem(const Parsed<Request>& parsed, const Case& expected) {
  const auto* problem = std::get_if<Problem>(&parsed);
  ASSERT_NE(problem, nullptr) << "was taken";
  EXPECT_EQ(problem->status, expected.status) << render(*problem);
  EXPECT_FALSE(problem->detail.empty());
  if (expected.pointer != nullptr) {
    EXPECT_TRUE(points_at(*problem, expected.pointer)) << render(*problem);
  }
}

std::string repeat(const std::string& text, std::size_t times) {
  std::string out;
  for (std::size_t i = 0; i < times; ++i) out += text;
  return out;
}

const std::string kScan = R"({"stamp": 1, "ranges": [1, 2, 3]})";

// --- A batch of a session -------------------------------------------------------------------

class SessionBatch : public testing::TestWithParam<Case> {};

TEST_P(SessionBatch, IsRefused) {
  expect_problem(parse_session_scans(GetParam().body, BodyFormat::kJson, three_beam_lidar(), {}),
                 GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    Unparsable, SessionBatch,
    testing::Values(
        Case{"Empty", "", 400}, Case{"Blank", "  \n", 400}, Case{"Text", "hello", 400},
        Case{"HalfAnAtom", "nul", 400}, Case{"Form", "sequence=1&scans=2", 400},
        Case{"Truncated", R"({"sequence": 0, "scans": [{"stamp": 1, "ranges": [1, 2)", 400},
        Case{"TruncatedInAString", R"({"sequence": 0, "sca)", 400},
        Case{"TruncatedBeforeTheEnd", R"({"sequence": 0, "scans": [)" + kScan + "]", 400},
        Case{"TrailingComma", R"({"sequence": 0, "scans": [)" + kScan + ",]}", 400},
        Case{"TrailingContent", session_batch(kScan) + " 1", 400},
        Case{"TwoDocuments", session_batch(kScan) + session_batch(kScan), 400},
        Case{"MissingComma", R"({"sequence": 0 "scans": []})", 400},
        Case{"MissingColon", R"({"sequence" 0})", 400},
        Case{"SingleQuotes", "{'sequence': 0}", 400}, Case{"UnquotedName", "{sequence: 0}", 400},
        Case{"Comment", "{} // batch", 400},
        Case{"NaNLiteral", session_batch(R"({"stamp": 1, "ranges": [1, NaN, 3]})"), 400},
        Case{"InfinityLiteral", session_batch(R"({"stamp": 1, "ranges": [1, Infinity, 3]})"), 400},
        Case{"LeadingZero", session_batch(R"({"stamp": 01, "ranges": [1, 2, 3]})"), 400},
        Case{"PlusSign", session_batch(R"({"stamp": +1, "ranges": [1, 2, 3]})"), 400},
        Case{"LoneMinus", session_batch(R"({"stamp": 1, "ranges": [1, -, 3]})"), 400},
        Case{"DotWithoutDigits", session_batch(R"({"stamp": 1, "ranges": [1, 2., 3]})"), 400},
        Case{"BrokenRange", session_batch(R"({"stamp": 1, "ranges": [1, 2x, 3]})"), 400},
        Case{"BrokenIntensity",
             session_batch(R"({"stamp": 1, "ranges": [1, 2, 3], "intensities": [1, tru]})"), 400},
        Case{"BrokenUnknownMember",
             session_batch(R"({"stamp": 1, "ranges": [1, 2, 3], "x": [nil]})"), 400},
        Case{"InvalidUtf8", "{\"sequence\": 0, \"note\": \"\xff\xfe\", \"scans\": []}", 400},
        Case{"OverlongUtf8", "{\"sequence\": 0, \"note\": \"\xc0\xaf\", \"scans\": []}", 400},
        Case{"LoneSurrogate", R"({"sequence": 0, "note": "\ud800", "scans": []})", 400},
        Case{"ControlCharacter", "{\"sequence\": 0, \"note\": \"a\nb\"}", 400},
        Case{"BadEscape", R"({"sequence": 0, "note": "\x"})", 400},
        Case{"ByteOrderMarkAlone", "\xEF\xBB\xBF", 400},
        Case{"NulBytes", std::string(64, '\0'), 400},
        Case{"DuplicateMember", R"({"sequence": 0, "sequence": 1, "scans": []})", 400},
        Case{"DuplicateScans",
             R"({"sequence": 0, "scans": [)" + kScan + R"(], "scans": [)" + kScan + "]}", 400},
        Case{"DuplicateRanges", session_batch(R"({"stamp": 1, "ranges": [1], "ranges": [2]})"),
             400},
        Case{"DeepArrays", R"({"x": )" + repeat("[", 100'000) + repeat("]", 100'000) + "}", 400},
        Case{"DeepObjects",
             R"({"x": )" + repeat(R"({"x": )", 2'000) + "1" + repeat("}", 2'000) + "}", 400},
        Case{"DeepRootArrays", repeat("[", 100'000), 400},
        Case{"DeepRanges",
             session_batch(R"({"stamp": 1, "ranges": )" + repeat("[", 5'000) + repeat("]", 5'000) +
                           "}"),
             400}),
    case_name);

INSTANTIATE_TEST_SUITE_P(NoObject, SessionBatch,
                         testing::Values(Case{"Array", "[" + kScan + "]", 422},
                                         Case{"EmptyArray", "[]", 422}, Case{"Number", "17", 400},
                                         Case{"String", R"("scan")", 400},
                                         Case{"Null", "null", 400}, Case{"True", "true", 400}),
                         case_name);

INSTANTIATE_TEST_SUITE_P(
    WrongMember, SessionBatch,
    testing::Values(
        Case{"NoMembers", "{}", 422, "/sequence"},
        Case{"NoScans", R"({"sequence": 0})", 422, "/scans"},
        Case{"NullScans", R"({"sequence": 0, "scans": null})", 422, "/scans"},
        Case{"EmptyScans", session_batch(""), 422, "/scans"},
        Case{"ScansAnObject", R"({"sequence": 0, "scans": {}})", 422, "/scans"},
        Case{"ScansAString", R"({"sequence": 0, "scans": "all"})", 422, "/scans"},
        Case{"NoSequence", R"({"scans": [)" + kScan + "]}", 422, "/sequence"},
        Case{"NegativeSequence", R"({"sequence": -1, "scans": [)" + kScan + "]}", 422, "/sequence"},
        Case{"FractionalSequence", R"({"sequence": 0.5, "scans": [)" + kScan + "]}", 422,
             "/sequence"},
        Case{"HugeSequence", R"({"sequence": 1e300, "scans": [)" + kScan + "]}", 422, "/sequence"},
        Case{"SequenceAboveInt64",
             R"({"sequence": 18446744073709551615, "scans": [)" + kScan + "]}", 422, "/sequence"},
        Case{"SequenceAString", R"({"sequence": "0", "scans": [)" + kScan + "]}", 422, "/sequence"},
        Case{"SequenceABoolean", R"({"sequence": true, "scans": [)" + kScan + "]}", 422,
             "/sequence"},
        Case{"ScanANumber", session_batch(kScan + ", 5"), 422, "/scans/1"},
        Case{"ScanNull", session_batch("null"), 422, "/scans/0"},
        Case{"ScanAnArray", session_batch("[1, 2, 3]"), 422, "/scans/0"},
        Case{"EmptyScan", session_batch("{}"), 422, "/scans/0/ranges"},
        Case{"NoStamp", session_batch(R"({"ranges": [1, 2, 3]})"), 422, "/scans/0/stamp"},
        Case{"StampAString", session_batch(R"({"stamp": "1", "ranges": [1, 2, 3]})"), 422,
             "/scans/0/stamp"},
        Case{"StampInfinite", session_batch(R"({"stamp": 1e999, "ranges": [1, 2, 3]})"), 422,
             "/scans/0/stamp"},
        Case{"StampNull", session_batch(R"({"stamp": null, "ranges": [1, 2, 3]})"), 422,
             "/scans/0/stamp"},
        Case{"StampsEqual", session_batch(kScan + ", " + kScan), 422, "/scans/1/stamp"},
        Case{"StampsFall", session_batch(kScan + R"(, {"stamp": 0.5, "ranges": [1, 2, 3]})"), 422,
             "/scans/1/stamp"},
        Case{"NoRanges", session_batch(R"({"stamp": 1})"), 422, "/scans/0/ranges"},
        Case{"RangesNull", session_batch(R"({"stamp": 1, "ranges": null})"), 422,
             "/scans/0/ranges"},
        Case{"RangesAString", session_batch(R"({"stamp": 1, "ranges": "1,2,3"})"), 422,
             "/scans/0/ranges"},
        Case{"RangesAnObject", session_batch(R"({"stamp": 1, "ranges": {"0": 1}})"), 422,
             "/scans/0/ranges"},
        Case{"RangesANumber", session_batch(R"({"stamp": 1, "ranges": 3})"), 422,
             "/scans/0/ranges"},
        Case{"RangesEmpty", session_batch(R"({"stamp": 1, "ranges": []})"), 422, "/scans/0/ranges"},
        Case{"TooFewBeams", session_batch(R"({"stamp": 1, "ranges": [1, 2]})"), 422,
             "/scans/0/ranges"},
        Case{"TooManyBeams", session_batch(kScan + R"(, {"stamp": 2, "ranges": [1, 2, 3, 4]})"),
             422, "/scans/1/ranges"},
        Case{"RangeAString", session_batch(R"({"stamp": 1, "ranges": [1, "2", 3]})"), 422,
             "/scans/0/ranges/1"},
        Case{"RangeABoolean", session_batch(R"({"stamp": 1, "ranges": [1, 2, true]})"), 422,
             "/scans/0/ranges/2"},
        Case{"RangeAnObject", session_batch(R"({"stamp": 1, "ranges": [{"r": 1}, 2, 3]})"), 422,
             "/scans/0/ranges/0"},
        Case{"RangeAnArray", session_batch(kScan + R"(, {"stamp": 2, "ranges": [1, [2, "x"], 3]})"),
             422, "/scans/1/ranges/1"},
        Case{"OdomAnArray",
             session_batch(R"({"stamp": 1, "ranges": [1, 2, 3], "odom": [1, 2, 3]})"), 422,
             "/scans/0/odom"},
        Case{"OdomWithoutYaw",
             session_batch(R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 1, "y": 2}})"), 422,
             "/scans/0/odom/yaw"},
        Case{"OdomNotFinite",
             session_batch(
                 R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 1e999, "y": 2, "yaw": 0}})"),
             422, "/scans/0/odom/x"},
        Case{"OdomOffTheEarth",
             session_batch(
                 R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 1, "y": -1e12, "yaw": 0}})"),
             422, "/scans/0/odom/y"},
        Case{"OdomYawNull",
             session_batch(
                 R"({"stamp": 1, "ranges": [1, 2, 3], "odom": {"x": 1, "y": 2, "yaw": null}})"),
             422, "/scans/0/odom/yaw"},
        Case{"HeaderWithoutStamp", session_batch(R"({"header": {}, "ranges": [1, 2, 3]})"), 422,
             "/scans/0/header/stamp"},
        Case{"HeaderAString", session_batch(R"({"header": "h", "ranges": [1, 2, 3]})"), 422,
             "/scans/0/header"},
        Case{"RosStampEmpty", session_batch(R"({"header": {"stamp": {}}, "ranges": [1, 2, 3]})"),
             422, "/scans/0/header/stamp/sec"},
        Case{"RosStampWithManyNanoseconds",
             session_batch(R"({"header": {"stamp": {"secs": 1, "nsecs": 1000000000}},
                               "ranges": [1, 2, 3]})"),
             422, "/scans/0/header/stamp/nsecs"},
        Case{"OwnIncrementZero",
             session_batch(R"({"stamp": 1, "ranges": [1, 2, 3], "angle_increment": 0})"), 422,
             "/scans/0/angle_increment"},
        Case{"OwnRangesSwapped",
             session_batch(R"({"stamp": 1, "ranges": [1, 2, 3], "range_min": 5, "range_max": 4})"),
             422, "/scans/0/range_max"},
        Case{"OwnAngleAString",
             session_batch(R"({"stamp": 1, "ranges": [1, 2, 3], "angle_min": "left"})"), 422,
             "/scans/0/angle_min"},
        Case{"MoreThanATurn",
             session_batch(R"({"stamp": 1, "ranges": [1, 2, 3], "angle_increment": 100})"), 422,
             "/scans/0/ranges"}),
    case_name);

INSTANTIATE_TEST_SUITE_P(
    TooLarge, SessionBatch,
    testing::Values(
        Case{"Scans", session_batch(repeat(kScan + ", ", 100) + kScan), 413, "/scans"},
        Case{"ScansOfNothing", session_batch(repeat("0, ", 100) + "0"), 413, "/scans"},
        Case{"Beams", session_batch(R"({"stamp": 1, "ranges": [)" + repeat("1, ", 20'000) + "1]}"),
             413, "/scans/0/ranges"},
        Case{"BeamsOfNothing",
             session_batch(kScan + R"(, {"stamp": 1, "ranges": [)" + repeat("{}, ", 20'000) +
                           "{}]}"),
             413, "/scans/1/ranges"},
        Case{"Values", R"({"x": [)" + repeat("1, ", 600'000) + "1]}", 413}),
    case_name);

// --- Other requests -------------------------------------------------------------------------

class MapBatch : public testing::TestWithParam<Case> {};

TEST_P(MapBatch, IsRefused) {
  expect_problem(parse_map_scans(GetParam().body, BodyFormat::kJson, three_beam_lidar(), {}),
                 GetParam());
}

const std::string kPosed =
    R"({"stamp": 1, "ranges": [1, 2, 3], "pose": {"x": 0, "y": 0, "yaw": 0}})";

INSTANTIATE_TEST_SUITE_P(
    Wrong, MapBatch,
    testing::Values(
        Case{"NoPose", R"({"scans": [)" + kPosed + ", " + kScan + "]}", 422, "/scans/1/pose"},
        Case{"PoseNull", R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3], "pose": null}]})", 422,
             "/scans/0/pose"},
        Case{"PoseNotFinite",
             R"({"scans": [{"stamp": 1, "ranges": [1, 2, 3],
                            "pose": {"x": 0, "y": 0, "yaw": 1e999}}]})",
             422, "/scans/0/pose/yaw"},
        Case{"LidarAString", R"({"lidar": "hokuyo", "scans": [)" + kPosed + "]}", 422, "/lidar"},
        Case{"LidarWithOtherBeams",
             R"({"lidar": {"angle_min": 0, "angle_increment": 1, "range_min": 0, "range_max": 1,
                           "beams": 2}, "scans": [)" +
                 kPosed + "]}",
             422, "/scans/0/ranges"},
        // The map's lidar said again, without the number of beams that its first scan had.
        Case{"OtherBeamsOfTheSameLidar",
             std::string(R"({"lidar": )") + kLidarText +
                 R"(, "scans": [{"stamp": 1, "ranges": [1], "pose": {"x": 0, "y": 0, "yaw": 0}}]})",
             422, "/scans/0/ranges"}),
    case_name);

TEST(MapBatchWithoutLidar, IsRefusedWhenTheScansBringNone) {
  expect_problem(parse_map_scans(R"({"scans": [)" + kPosed + "]}", BodyFormat::kJson, {}, {}),
                 {"", "", 422, "/lidar"});
}

class NewSession : public testing::TestWithParam<Case> {};

TEST_P(NewSession, IsRefused) {
  expect_problem(parse_create_session(GetParam().body, BodyFormat::kJson), GetParam());
}

std::string session(const std::string& members) {
  return std::string(R"({"robot": "r2", "lidar": )") + kLidarText + ", " + members + "}";
}

std::string session_with_lidar(const std::string& members) {
  return R"({"robot": "r2", "lidar": {)" + members + "}}";
}

INSTANTIATE_TEST_SUITE_P(
    Wrong, NewSession,
    testing::Values(
        Case{"NoRobot", std::string(R"({"lidar": )") + kLidarText + "}", 422, "/robot"},
        Case{"RobotEmpty", std::string(R"({"robot": "", "lidar": )") + kLidarText + "}", 422,
             "/robot"},
        Case{"RobotWithASlash", std::string(R"({"robot": "a/b", "lidar": )") + kLidarText + "}",
             422, "/robot"},
        Case{"RobotANumber", std::string(R"({"robot": 2, "lidar": )") + kLidarText + "}", 422,
             "/robot"},
        Case{"NoLidar", R"({"robot": "r2"})", 422, "/lidar"},
        Case{"MapANumber", session(R"("map": 3)"), 422, "/map"},
        Case{"MapsAString", session(R"("maps": "a")"), 422, "/maps"},
        Case{"MapsEmpty", session(R"("maps": [])"), 422, "/maps"},
        Case{"MapsWithAWrongName", session(R"("maps": ["a", ".b"])"), 422, "/maps/1"},
        Case{"MapAndMaps", session(R"("map": "a", "maps": ["b"])"), 422, "/maps"},
        Case{"OptionsAList", session(R"("options": [])"), 422, "/options"},
        Case{"UnknownOption", session(R"("options": {"sede": 2})"), 422, "/options/sede"},
        Case{"UnknownOptionWithASlash", session(R"("options": {"a/b~c": 2})"), 422,
             "/options/a~1b~0c"},
        Case{"UnknownNestedOption", session(R"("options": {"acceptance": {"p": 2}})"), 422,
             "/options/acceptance/p"},
        Case{"UnknownMethod", session(R"("options": {"method": "sift"})"), 422, "/options/method"},
        Case{"MethodANumber", session(R"("options": {"method": 1})"), 422, "/options/method"},
        Case{"SeedNegative", session(R"("options": {"seed": -1})"), 422, "/options/seed"},
        Case{"OptionOutOfRange", session(R"("options": {"min_features": 0})"), 422,
             "/options/min_features"},
        Case{"OptionAboveInt", session(R"("options": {"min_votes": 4294967297})"), 422,
             "/options/min_votes"},
        Case{"NestedOptionOutOfRange",
             session(R"("options": {"acceptance": {"min_probability": 1.5}})"), 422,
             "/options/acceptance/min_probability"},
        Case{"LidarWithoutMembers", session_with_lidar(""), 422, "/lidar/angle_min"},
        Case{"LidarWithoutRangeMax",
             session_with_lidar(R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0)"), 422,
             "/lidar/range_max"},
        Case{"LidarIncrementZero",
             session_with_lidar(
                 R"("angle_min": 0, "angle_increment": 0, "range_min": 0, "range_max": 9)"),
             422, "/lidar/angle_increment"},
        Case{"LidarRangeMinNegative",
             session_with_lidar(
                 R"("angle_min": 0, "angle_increment": 0.1, "range_min": -1, "range_max": 9)"),
             422, "/lidar/range_min"},
        Case{"LidarBeamsZero",
             session_with_lidar(R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "beams": 0)"),
             422, "/lidar/beams"},
        Case{"LidarBeamsHuge",
             session_with_lidar(R"("angle_min": 0, "angle_increment": 1e-300, "range_min": 0,
                                   "range_max": 9, "beams": 1000000000000)"),
             422, "/lidar/beams"},
        Case{"LidarOfTwoTurns",
             session_with_lidar(R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "beams": 130)"),
             422, "/lidar/beams"},
        Case{"LidarMountWithoutYaw",
             session_with_lidar(R"("angle_min": 0, "angle_increment": 0.1, "range_min": 0,
                                   "range_max": 9, "mount": {"x": 0, "y": 0})"),
             422, "/lidar/mount/yaw"}),
    case_name);

class NewMap : public testing::TestWithParam<Case> {};

TEST_P(NewMap, IsRefused) {
  expect_problem(parse_put_map(GetParam().body, BodyFormat::kJson), GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    Wrong, NewMap,
    testing::Values(
        Case{"Empty", "", 400},
        Case{"DescriptionANumber", R"({"description": 1})", 422, "/description"},
        Case{"DescriptionTooLong", R"({"description": ")" + std::string(5000, 'a') + R"("})", 422,
             "/description"},
        Case{"LidarEmpty", R"({"lidar": {}})", 422, "/lidar/range_min"},
        Case{"UnknownParameter", R"({"parameters": {"resolution": 1}})", 422,
             "/parameters/resolution"},
        Case{"UnknownNestedParameter", R"({"parameters": {"grid": {"cell": 1}}})", 422,
             "/parameters/grid/cell"},
        Case{"NestedParameterANumber", R"({"parameters": {"grid": 1}})", 422, "/parameters/grid"},
        Case{"ParameterOutOfRange", R"({"parameters": {"grid": {"resolution_m": 0}}})", 422,
             "/parameters/grid/resolution_m"},
        Case{"ParameterAString", R"({"parameters": {"min_feature_count": "2"}})", 422,
             "/parameters/min_feature_count"},
        Case{"ParameterFractional", R"({"parameters": {"min_feature_count": 2.5}})", 422,
             "/parameters/min_feature_count"}),
    case_name);

class Trajectory : public testing::TestWithParam<Case> {};

TEST_P(Trajectory, IsRefused) {
  expect_problem(parse_trajectory(GetParam().body, BodyFormat::kJson), GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    Wrong, Trajectory,
    testing::Values(
        Case{"NoPoses", "{}", 422, "/poses"}, Case{"EmptyPoses", R"({"poses": []})", 422, "/poses"},
        Case{"PosesAnObject", R"({"poses": {}})", 422, "/poses"},
        Case{"PoseAnArray", R"({"poses": [[1, 2, 3, 4]]})", 422, "/poses/0"},
        Case{"NoStamp", R"({"poses": [{"x": 0, "y": 0, "yaw": 0}]})", 422, "/poses/0/stamp"},
        Case{"NoYaw", R"({"poses": [{"stamp": 1, "x": 0, "y": 0}]})", 422, "/poses/0/yaw"}),
    case_name);

class Question : public testing::TestWithParam<Case> {};

TEST_P(Question, IsRefused) {
  expect_problem(parse_localize(GetParam().body, BodyFormat::kJson, {}), GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    Wrong, Question,
    testing::Values(Case{"NoLidar", R"({"scans": [)" + kScan + "]}", 422, "/lidar"},
                    Case{"ScanWithHalfAGeometry",
                         R"({"scans": [{"stamp": 1, "ranges": [1], "angle_min": 0}]})", 422,
                         "/scans/0/range_max"},
                    Case{"UnknownOption",
                         std::string(R"({"lidar": )") + kLidarText + R"(, "scans": [)" + kScan +
                             R"(], "options": {"x": 1}})",
                         422, "/options/x"}),
    case_name);

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
                 {GetParam().name, "", 400});
}

std::string half_of(const std::string& body) { return body.substr(0, body.size() / 2); }

std::string encoded_batch(BodyFormat format) {
  return encode_as(nlohmann::json::parse(session_batch(kScan)), format);
}

INSTANTIATE_TEST_SUITE_P(
    Broken, BinaryBody,
    testing::Values(
        BinaryCase{"CborEmpty", BodyFormat::kCbor, ""},
        BinaryCase{"CborTruncated", BodyFormat::kCbor, half_of(encoded_batch(BodyFormat::kCbor))},
        BinaryCase{"CborTrailing", BodyFormat::kCbor, encoded_batch(BodyFormat::kCbor) + "\x01"},
        BinaryCase{"CborThatIsJson", BodyFormat::kCbor, session_batch(kScan)},
        BinaryCase{"CborDeepArrays", BodyFormat::kCbor, std::string(1'000'000, '\x81')},
        BinaryCase{"CborDeepIndefiniteArrays", BodyFormat::kCbor, std::string(1'000'000, '\x9f')},
        BinaryCase{"CborDeepMaps", BodyFormat::kCbor, repeat("\xa1\x61x", 100'000)},
        BinaryCase{"CborDeepTags", BodyFormat::kCbor, std::string(1'000'000, '\xc1')},
        BinaryCase{"CborDeepIndefiniteText", BodyFormat::kCbor, std::string(1'000'000, '\x7f')},
        BinaryCase{"CborDeepIndefiniteKey", BodyFormat::kCbor,
                   "\xa1" + std::string(1'000'000, '\x7f')},
        BinaryCase{"CborDeepIndefiniteBytes", BodyFormat::kCbor, std::string(1'000'000, '\x5f')},
        BinaryCase{"CborDeepTextWithEmptyChunks", BodyFormat::kCbor, repeat("\x7f\x60", 500'000)},
        BinaryCase{"CborHugeArrayClaimed", BodyFormat::kCbor,
                   std::string("\x9b\x00\xff\xff\xff\xff\xff\xff\xff", 9)},
        BinaryCase{"CborHugeTextClaimed", BodyFormat::kCbor,
                   std::string("\x7b\x00\xff\xff\xff\xff\xff\xff\xff", 9)},
        BinaryCase{"CborNumberAsKey", BodyFormat::kCbor, "\xa1\x01\x02"},
        BinaryCase{"CborBadUtf8Value", BodyFormat::kCbor, "\xa1\x61x\x62\xff\xfe"},
        BinaryCase{"CborBadUtf8Key", BodyFormat::kCbor, "\xa1\x62\xff\xfe\x01"},
        BinaryCase{"CborDuplicateKey", BodyFormat::kCbor, "\xa2\x61x\x01\x61x\x02"},
        BinaryCase{"MessagePackEmpty", BodyFormat::kMessagePack, ""},
        BinaryCase{"MessagePackTruncated", BodyFormat::kMessagePack,
                   half_of(encoded_batch(BodyFormat::kMessagePack))},
        BinaryCase{"MessagePackTrailing", BodyFormat::kMessagePack,
                   encoded_batch(BodyFormat::kMessagePack) + "\x01"},
        BinaryCase{"MessagePackDeepArrays", BodyFormat::kMessagePack,
                   std::string(1'000'000, '\x91')},
        BinaryCase{"MessagePackDeepMaps", BodyFormat::kMessagePack, repeat("\x81\xa1x", 100'000)},
        BinaryCase{"MessagePackHugeArrayClaimed", BodyFormat::kMessagePack, "\xdd\xff\xff\xff\xff"},
        BinaryCase{"MessagePackBadUtf8Value", BodyFormat::kMessagePack, "\x81\xa1x\xa2\xff\xfe"},
        BinaryCase{"MessagePackNeverUsedByte", BodyFormat::kMessagePack, "\xc1"}),
    [](const testing::TestParamInfo<BinaryCase>& tested) {
      return std::string(tested.param.name);
    });

TEST(BinaryRoot, MustBeAnObject) {
  for (const BodyFormat format : {BodyFormat::kCbor, BodyFormat::kMessagePack}) {
    expect_problem(parse_put_map(encode_as(nlohmann::json::array(), format), format),
                   {"", "", 422});
    expect_problem(parse_put_map(encode_as(nlohmann::json(1), format), format), {"", "", 422});
  }
}

TEST(BinaryRange, MustNotBeAByteString) {
  nlohmann::json batch = nlohmann::json::parse(session_batch(kScan));
  batch["scans"][0]["ranges"] = nlohmann::json::binary({0, 0, 0});
  for (const BodyFormat format : {BodyFormat::kCbor, BodyFormat::kMessagePack}) {
    expect_problem(parse_session_scans(encode_as(batch, format), format, three_beam_lidar(), {}),
                   {"", "", 422, "/scans/0/ranges"});
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
  EXPECT_NE(problem.detail.find("method, seed"), std::string::npos) << problem.detail;
}

}  // namespace
}  // namespace cornerfix::api

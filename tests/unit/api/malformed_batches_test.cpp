#include "unit/api/refused_body.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <variant>

namespace cornerfix::api {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// --- A batch of a session -------------------------------------------------------------------

class SessionBatch : public ::testing::TestWithParam<Case> {};

TEST_P(SessionBatch, IsRefused) {
  expect_problem(parse_batch(GetParam().body), GetParam().status, GetParam().pointer);
}

/// The body has one batch of these scans.
class ScansOfABatch : public ::testing::TestWithParam<Case> {};

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
INSTANTIATE_TEST_SUITE_P(Unparsable, SessionBatch, ::testing::ValuesIn(kUnparsableBatches),
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
INSTANTIATE_TEST_SUITE_P(Unparsable, ScansOfABatch, ::testing::ValuesIn(kUnparsableScans),
                         case_name);

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
INSTANTIATE_TEST_SUITE_P(NoObject, SessionBatch, ::testing::ValuesIn(kNoObject), case_name);

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
INSTANTIATE_TEST_SUITE_P(WrongMember, SessionBatch, ::testing::ValuesIn(kWrongBatches), case_name);

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
    {"StampOfAnotherTimeThanTheHeader",
     R"({"stamp": 1, "ranges": [1, 2, 3], "header": {"stamp": {"sec": 5, "nanosec": 0}}})", 422,
     "/scans/0/stamp"},
    {"RosStampOfBothKinds",
     R"({"header": {"stamp": {"secs": 1, "nanosec": 5}}, "ranges": [1, 2, 3]})", 422,
     "/scans/0/header/stamp/nanosec"},
    {"TimeIncrementOfNoLidar", R"({"stamp": 1, "ranges": [1, 2, 3], "time_increment": 4})", 422,
     "/scans/0/time_increment"},
    {"MountInMillimetres",
     R"({"stamp": 1, "ranges": [1, 2, 3], "mount": {"x": 250, "y": 0, "yaw": 0}})", 422,
     "/scans/0/mount/x"},
    {"MountInDegrees", R"({"stamp": 1, "ranges": [1, 2, 3], "mount": {"x": 0, "y": 0, "yaw": 90}})",
     422, "/scans/0/mount/yaw"},
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
INSTANTIATE_TEST_SUITE_P(WrongMember, ScansOfABatch, ::testing::ValuesIn(kWrongScans), case_name);

/// The detail of the problem with a batch.
std::string fault_of(const std::string& body) {
  const auto parsed = parse_batch(body);
  const auto* problem = std::get_if<Problem>(&parsed);
  return problem != nullptr ? problem->detail : "";
}

TEST(UnparsableBody, IsNamedForWhatItIs) {
  const std::string batch = session_batch(R"({"stamp": 1, "ranges": [1, 2, 3]})");
  EXPECT_THAT(fault_of("\xEF\xBB\xBF" + batch), HasSubstr("begins with a byte order mark"));
  EXPECT_THAT(fault_of("\xFF\xFE{"), HasSubstr("the byte order mark of UTF-16"));
  EXPECT_THAT(fault_of("\x1f\x8b\x08"), HasSubstr("send Content-Encoding: gzip"));
  for (const char* number : {"NaN", "nan", "-inf", "Infinity"}) {
    const std::string ranges = "[1, " + std::string(number) + ", 3]";
    EXPECT_THAT(fault_of(session_batch(R"({"stamp": 1, "ranges": )" + ranges + "}")),
                HasSubstr("It has no NaN and no Infinity: send null."));
  }
  EXPECT_THAT(fault_of(R"({"header": {"stamp": {"nanosec": 1,}}})"), Not(HasSubstr("NaN")));
}

TEST(UnparsableBody, IsNamedWithThePlace) {
  EXPECT_THAT(fault_of(R"({"sequence": 0, "scans": [{"stamp": 1, "ranges": [1, 2,]}]})"),
              HasSubstr(" at byte 55: ]}]}"));
  EXPECT_THAT(fault_of(R"({"sequence": 0,})"), HasSubstr(" at byte 15: }"));
  EXPECT_THAT(fault_of(R"({"sequence": None})"), HasSubstr(" at byte 13: None}"));
  EXPECT_THAT(fault_of(R"({"sequence": 0} {})"),
              HasSubstr("there is more after its end at byte 16: {}"));
  EXPECT_THAT(fault_of("{\"sequence\": 01, \"a\": \"\xC3\xBC\"}"), HasSubstr(" at byte 13: 01, "));
  EXPECT_EQ(fault_of(R"({"sequence": 0)").find(" at byte"), std::string::npos);
}

TEST(StampInMilliseconds, IsAskedFor) {
  EXPECT_THAT(fault_of(session_batch(R"({"stamp": 1700000000000, "ranges": [1, 2, 3]})")),
              HasSubstr("from -1e12 to 1e12: are these milli- or nanoseconds?"));
}

TEST(StampBesideAHeader, IsTakenWhenItIsTheSameTime) {
  EXPECT_EQ(fault_of(session_batch(
                R"({"stamp": 5.25, "ranges": [1, 2, 3],
                    "header": {"stamp": {"sec": 5, "nanosec": 250000000}}})")),
            "");
}

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

class MapBatch : public ::testing::TestWithParam<Case> {};

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
INSTANTIATE_TEST_SUITE_P(Wrong, MapBatch, ::testing::ValuesIn(kWrongMapBatches), case_name);

TEST(MapBatchWithoutLidar, IsRefusedWhenTheScansBringNone) {
  const std::string posed =
      R"({"stamp": 1, "ranges": [1, 2, 3], "pose": {"x": 0, "y": 0, "yaw": 0}})";
  expect_problem(parse_map_scans(R"({"scans": [)" + posed + "]}", BodyFormat::kJson, {}, {}), 422,
                 "/lidar");
}

}  // namespace
}  // namespace cornerfix::api

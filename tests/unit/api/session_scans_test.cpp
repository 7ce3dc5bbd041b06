#include "api/requests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <string>

#include "unit/api/scan_text.hpp"
#include "unit/api/taken.hpp"

namespace cornerfix::api {
namespace {

using ::testing::ElementsAre;
using ::testing::FloatEq;
using testing::NanSensitiveFloatEq;

using std::numbers::pi;
const float kNoReturn = std::numeric_limits<float>::quiet_NaN();

SessionScansRequest session_scans(const std::string& scans) {
  return taken(
      parse_session_scans(session_batch(scans), BodyFormat::kJson, three_beam_lidar(), {}));
}

TEST(SessionScans, HaveTheLidarsGeometryAndTheirOwnValues) {
  Lidar lidar = three_beam_lidar();
  lidar.T_base_link_laser = {0.2, 0.0, pi};
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
  EXPECT_EQ(scan.T_base_link_laser, (Pose2{0.2, 0.0, pi}));
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

TEST(SessionScans, AreCutToAFullTurn) {
  const auto request = session_scans(R"({"stamp": 1, "angle_min": 0, "angle_increment": 0.5,
      "ranges": [1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 2, 3, 4, 5, 6]})");
  ASSERT_EQ(request.scans.size(), 1U);
  EXPECT_EQ(request.scans[0].scan.ranges.size(), 12U);
  EXPECT_EQ(request.scans[0].scan.ranges.back(), 3.0F);
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
  EXPECT_DOUBLE_EQ(request.scans.at(0).T_odom_base_link->yaw, pi);
  EXPECT_DOUBLE_EQ(request.scans.at(1).T_odom_base_link->yaw, 7.0 - 2.0 * pi);
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
  EXPECT_NEAR(T_odom_base_link->yaw, pi / 2.0, 1e-12);
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

TEST(SessionScans, TakeTheStampBesideAHeaderWithoutOne) {
  const auto request =
      session_scans(R"({"stamp": 3, "header": {"frame_id": "laser"}, "ranges": [1, 2, 3]})");
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

}  // namespace
}  // namespace cornerfix::api

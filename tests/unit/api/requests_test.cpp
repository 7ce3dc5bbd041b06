#include "api/requests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <string>
#include <variant>

#include "api/body_reader.hpp"
#include "unit/api/scan_text.hpp"
#include "unit/api/taken.hpp"

namespace cornerfix::api {
namespace {

using std::numbers::pi;

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

TEST(MapScans, MayHaveOneValueMorePer32Ranges) {
  const auto is_read = [](std::size_t ranges, std::size_t values) {
    std::string body = R"({"scans": [{"ranges": [1)";
    for (std::size_t i = 1; i < ranges; ++i) body += ",1";
    body += R"(]}], "x": [)";
    constexpr std::size_t kBesides = 5;  // The body, scans, the scan, ranges and x.
    for (std::size_t i = kBesides; i < values; ++i) body += i == kBesides ? "1" : ",1";
    return std::holds_alternative<Document>(read_body(body + "]}", BodyFormat::kJson, {}));
  };
  EXPECT_TRUE(is_read(31, 500'000));
  EXPECT_FALSE(is_read(31, 500'001));
  EXPECT_TRUE(is_read(20'000, 500'625));
  EXPECT_FALSE(is_read(20'000, 500'626));
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
  EXPECT_FALSE(request.description || request.lidar || request.parameters_json);
}

TEST(PutMap, TakesNullAsAbsent) {
  const auto request = taken(parse_put_map(
      R"({"description": null, "lidar": null, "parameters": null})", BodyFormat::kJson));
  EXPECT_FALSE(request.description || request.lidar || request.parameters_json);
}

TEST(PutMap, TakesWhatIsGiven) {
  const auto request = taken(parse_put_map(
      R"({"description": "Büro 2", "lidar": {"angle_min": -1.5, "angle_increment": 0.01,
          "range_min": 0.05, "range_max": 30, "beams": 300,
          "mount": {"x": 0.1, "y": 0.2, "yaw": 4}},
          "parameters": {"key_frame_distance_m": 0.5, "extractor": "vfp", "grid": {"resolution_m": 0.1}}})",
      BodyFormat::kJson));
  EXPECT_EQ(request.description, "Büro 2");
  ASSERT_TRUE(request.lidar.has_value());
  EXPECT_EQ(request.lidar->beams, 300U);
  EXPECT_EQ(request.lidar->T_base_link_laser, (Pose2{0.1, 0.2, wrap_angle(4.0)}));
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
              .T_base_link_laser = {0.1 + 0.2, -1.0 / 3.0, pi}};
  EXPECT_EQ(lidar_from_json(lidar_to_json(lidar)), lidar);
  lidar.beams.reset();
  EXPECT_EQ(lidar_from_json(lidar_to_json(lidar)), lidar);
}

TEST(StoredTexts, GiveALidarWithoutLimitBack) {
  const auto request = taken(parse_put_map(
      R"({"lidar": {"angle_min": 0, "angle_increment": 0.1, "range_min": 0, "range_max": null}})",
      BodyFormat::kJson));
  ASSERT_TRUE(request.lidar.has_value());
  const std::string stored = lidar_to_json(*request.lidar);
  EXPECT_THAT(stored, ::testing::HasSubstr(R"("range_max":null)"));
  const auto lidar = lidar_from_json(stored);
  ASSERT_TRUE(lidar.has_value());
  EXPECT_EQ(lidar->range_max, std::numeric_limits<double>::infinity());
  EXPECT_TRUE(is_put_map_request("", stored, ""));
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

#include "api/binary_batch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>

#include "support/binary_text.hpp"
#include "unit/api/refused_body.hpp"
#include "unit/api/taken.hpp"

namespace cornerfix::api {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr float kInfiniteRange = std::numeric_limits<float>::infinity();
constexpr std::size_t kHeaderBytes = 24;

Parsed<SessionScansRequest> parse_binary(const std::string& body,
                                         const Lidars& lidars = three_beam_lidar()) {
  return parse_session_scans(body, BodyFormat::kBinaryBatch, lidars, {});
}

std::string two_scans() {
  return binary_header({.flags = 1, .sequence = 7, .scans = 2, .beams = 3}) +
         binary_text(12.5, 1.0, -2.0, 0.5, 1.0F, kInfiniteRange, 3.25F) +
         binary_text(13.0, 1.5, -2.0, 0.5, 0.0F, -4.0F, 2.0F);
}

std::string detail_of(const std::string& body) {
  const auto parsed = parse_binary(body);
  const auto* problem = std::get_if<Problem>(&parsed);
  if (problem == nullptr) return "was taken";
  EXPECT_EQ(problem->status, 400);
  return problem->detail;
}

TEST(BinaryBatch, IsTheSameAsInJson) {
  const auto binary = taken(parse_binary(two_scans()));
  const auto json = taken(parse_batch(R"({"sequence": 7, "scans": [
      {"stamp": 12.5, "ranges": [1, null, 3.25], "odom": {"x": 1, "y": -2, "yaw": 0.5}},
      {"stamp": 13, "ranges": [0, -4, 2], "odom": {"x": 1.5, "y": -2, "yaw": 0.5}}]})"));
  EXPECT_EQ(binary.sequence, 7U);
  ASSERT_EQ(binary.scans.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(binary.scans[i].scan.stamp, json.scans[i].scan.stamp);
    EXPECT_EQ(binary.scans[i].scan.angle_increment, 0.5);
    EXPECT_EQ(binary.scans[i].T_odom_base_link, json.scans[i].T_odom_base_link);
    for (std::size_t beam = 0; beam < 3; ++beam) {
      EXPECT_EQ(binary.scans[i].scan.has_return(beam), json.scans[i].scan.has_return(beam));
    }
  }
  EXPECT_THAT(binary.scans[1].scan.ranges, ElementsAre(0.0F, -4.0F, 2.0F));
}

TEST(BinaryBatch, MayHaveNoOdometry) {
  const auto request = taken(
      parse_binary(binary_header({.scans = 1, .beams = 3}) + binary_text(12.5, 1.0F, 2.0F, 3.0F)));
  EXPECT_EQ(request.scans.at(0).T_odom_base_link, std::nullopt);
  EXPECT_THAT(request.scans.at(0).scan.ranges, ElementsAre(1.0F, 2.0F, 3.0F));
}

TEST(BinaryBatch, TakesNanAsNoReturn) {
  const auto request =
      taken(parse_binary(binary_header({.scans = 1, .beams = 3}) +
                         binary_text(12.5, static_cast<float>(kNan), -kInfiniteRange, 3.0F)));
  EXPECT_FALSE(request.scans.at(0).scan.has_return(0));
  EXPECT_FALSE(request.scans.at(0).scan.has_return(1));
  EXPECT_TRUE(request.scans.at(0).scan.has_return(2));
}

TEST(BinaryBatch, ThatIsSomethingElseNamesTheByte) {
  EXPECT_THAT(detail_of(R"({"sequence": 0, "scans": []})"), HasSubstr("Byte 0: expected"));
  EXPECT_THAT(detail_of("CFS2" + two_scans().substr(4)), HasSubstr("Byte 0: expected"));
  EXPECT_THAT(detail_of(binary_header({.flags = 2}) + two_scans()), HasSubstr("Byte 4: flags 2"));
}

TEST(BinaryBatch, ThatEndsEarlyOrLateStatesTheSizes) {
  const std::string body = two_scans();
  for (std::size_t size = 4; size < kHeaderBytes; ++size) {
    EXPECT_THAT(detail_of(body.substr(0, size)), HasSubstr("header of 24")) << size;
  }
  for (std::size_t size = kHeaderBytes; size < body.size(); ++size) {
    EXPECT_THAT(detail_of(body.substr(0, size)), HasSubstr("2 scans of 44")) << size;
  }
  EXPECT_THAT(detail_of(body + '\0'), HasSubstr("has 113 bytes"));
}

TEST(BinaryBatch, ThatClaimsMoreThanCanBeCountedIsRefused) {
  constexpr auto kMost = std::numeric_limits<std::uint32_t>::max();
  for (const std::uint32_t scans : {0U, 1U, 1U << 30U, kMost}) {
    for (const std::uint32_t beams : {1U << 30U, kMost - 1, kMost}) {
      const std::string body = binary_header({.scans = scans, .beams = beams});
      EXPECT_GE(std::get<Problem>(parse_binary(body + "12345678")).status, 400);
    }
  }
}

TEST(BinaryBatch, ObeysTheLimits) {
  const auto status = [](const RequestLimits& limits) {
    const auto parsed = parse_session_scans(two_scans(), BodyFormat::kBinaryBatch,
                                            Lidars(three_beam_lidar()), limits);
    const auto* problem = std::get_if<Problem>(&parsed);
    return problem != nullptr ? problem->status : 200;
  };
  EXPECT_EQ(status({.max_scans = 2, .max_beams = 3}), 200);
  EXPECT_EQ(status({.max_scans = 1, .max_beams = 3}), 413);
  EXPECT_EQ(status({.max_scans = 2, .max_beams = 2}), 413);
}

TEST(BinaryBatch, PointsAtWrongValues) {
  const std::string header = binary_header({.flags = 1, .scans = 1, .beams = 3});
  expect_problem(parse_binary(header + binary_text(kNan, 0.0, 0.0, 0.0, 1.0F, 2.0F, 3.0F)), 422,
                 "/scans/0/stamp");
  expect_problem(parse_binary(header + binary_text(1.0, 0.0, kNan, 0.0, 1.0F, 2.0F, 3.0F)), 422,
                 "/scans/0/odom/y");
  expect_problem(
      parse_binary(binary_header({.scans = 1, .beams = 2}) + binary_text(1.0, 1.0F, 2.0F)), 422,
      "/scans/0/ranges");
  expect_problem(parse_binary(binary_header({.scans = 0, .beams = 3})), 422, "/scans");
}

TEST(BinaryBatch, NeedsTheOneLidarOfASession) {
  expect_problem(parse_binary(two_scans(), Lidars()), 422, "/lidar");
  const Lidars named = taken(session_with_lidars(lidars_text())).lidars;
  expect_problem(parse_binary(two_scans(), named), 422, "/scans/0/lidar");
}

TEST(BinaryBatch, IsNoBodyOfAnotherCall) {
  expect_problem(parse_create_session(two_scans(), BodyFormat::kBinaryBatch), 422, "/scans");
  expect_problem(parse_put_map(two_scans(), BodyFormat::kBinaryBatch), 422, "/scans");
}

}  // namespace
}  // namespace cornerfix::api

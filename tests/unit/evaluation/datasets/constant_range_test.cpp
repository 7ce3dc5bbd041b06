#include "evaluation/datasets/constant_range.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace cornerfix::evaluation {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kBeams = 180;
constexpr std::size_t kScans = ConstantRange::kScans;

/// A room of about 5 m. The first `silent` beams have `no_return`.
LaserScan scan_of_room(std::size_t number, std::size_t silent, float no_return) {
  LaserScan scan{.angle_increment = 0.0174533, .range_max = 100.0, .ranges = {}};
  for (std::size_t beam = 0; beam < kBeams; ++beam) {
    const auto range = 5.0 + 0.4 * std::sin(0.7 * static_cast<double>(beam + number));
    scan.ranges.push_back(beam < silent ? no_return : static_cast<float>(range));
  }
  return scan;
}

std::size_t returns_after(ConstantRange& constant, LaserScan scan) {
  constant.clear(scan);
  return returns_as_points(scan).size();
}

TEST(ConstantRange, IsFoundWhereManyBeamsHaveTheLongestRange) {
  ConstantRange constant;
  for (std::size_t i = 0; i < 3 * kScans; ++i) constant.look_at(scan_of_room(i, 20, 65.533F));
  EXPECT_EQ(returns_after(constant, scan_of_room(0, 20, 65.533F)), kBeams - 20);
  EXPECT_EQ(constant.note(),
            "20 ranges of exactly 65.533 m are taken for no returns: none is longer, and hits of a "
            "wall would differ");
}

TEST(ConstantRange, IsFoundWhereItBeginsLate) {
  ConstantRange constant;
  for (std::size_t i = 0; i < 100; ++i) constant.look_at(scan_of_room(i, 0, 0.0F));
  for (std::size_t i = 0; i < kScans; ++i) constant.look_at(scan_of_room(i, 20, 30.0F));
  EXPECT_EQ(returns_after(constant, scan_of_room(0, 20, 30.0F)), kBeams - 20);
}

TEST(ConstantRange, IsNoneWhereTheLongestRangesDiffer) {
  ConstantRange constant;
  for (std::size_t i = 0; i < kScans; ++i) constant.look_at(scan_of_room(i, 0, 0.0F));
  EXPECT_EQ(returns_after(constant, scan_of_room(0, 0, 0.0F)), kBeams);
  EXPECT_EQ(constant.note(), "");
}

TEST(ConstantRange, IsNoneForAWallAheadOfARobotAtRest) {
  ConstantRange constant;
  for (std::size_t i = 0; i < kScans; ++i) constant.look_at(scan_of_room(0, 3, 25.0F));
  EXPECT_EQ(returns_after(constant, scan_of_room(0, 3, 25.0F)), kBeams);
}

TEST(ConstantRange, IsNoneForARangeThatIsNotTheLongest) {
  ConstantRange constant;
  for (std::size_t i = 0; i < kScans; ++i) constant.look_at(scan_of_room(i, 20, 1.5F));
  EXPECT_EQ(returns_after(constant, scan_of_room(0, 20, 1.5F)), kBeams);
}

TEST(ConstantRange, IsNoneWhereAllRangesAreTheSame) {
  ConstantRange constant;
  for (std::size_t i = 0; i < kScans; ++i) constant.look_at(scan_of_room(i, kBeams, 2.0F));
  EXPECT_EQ(returns_after(constant, scan_of_room(0, kBeams, 2.0F)), kBeams);
}

TEST(ConstantRange, NeedsSeveralScans) {
  ConstantRange constant;
  for (std::size_t i = 0; i < 3; ++i) constant.look_at(scan_of_room(i, 20, 65.533F));
  EXPECT_EQ(returns_after(constant, scan_of_room(0, 20, 65.533F)), kBeams);
}

}  // namespace
}  // namespace cornerfix::evaluation

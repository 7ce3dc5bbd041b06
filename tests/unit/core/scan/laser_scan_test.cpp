#include <cornerfix/laser_scan.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using testing::IsPointNear;

using std::numbers::pi;
constexpr float kNoReturn = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

LaserScan quarter_turns(std::vector<float> ranges) {
  return {.angle_min = -pi,
          .angle_increment = pi / 2.0,
          .range_min = 0.1,
          .range_max = 10.0,
          .ranges = std::move(ranges)};
}

TEST(LaserScan, LooksAlongItsBearings) {
  const std::vector<Point2> points = returns_as_points(quarter_turns({1.0F, 2.0F, 3.0F, 4.0F}));
  EXPECT_THAT(points, ::testing::ElementsAre(
                          IsPointNear(Point2(-1, 0), 1e-9), IsPointNear(Point2(0, -2), 1e-9),
                          IsPointNear(Point2(3, 0), 1e-9), IsPointNear(Point2(0, 4), 1e-9)));
}

TEST(LaserScan, AClockwiseLidarLooksTheOtherWay) {
  LaserScan scan = quarter_turns({1.0F, 2.0F});
  scan.angle_min = 0.0;
  scan.angle_increment = -pi / 2.0;
  EXPECT_THAT(returns_as_points(scan), ::testing::ElementsAre(IsPointNear(Point2(1, 0), 1e-9),
                                                              IsPointNear(Point2(0, -2), 1e-9)));
}

TEST(LaserScan, LooksAlongItsBearingsAfterScansOfOtherLidars) {
  LaserScan first{.angle_min = 0.3, .angle_increment = 0.7, .range_max = 10.0, .ranges = {1, 2}};
  LaserScan longer = first;
  longer.ranges = {1, 2, 3, 4};
  LaserScan later = first;
  later.angle_min = 1.1;
  LaserScan finer = first;
  finer.angle_increment = 0.1;
  for (const LaserScan& scan : {first, longer, later, finer, first}) {
    const std::vector<Point2> points = returns_as_points(scan);
    ASSERT_EQ(points.size(), scan.ranges.size());
    for (std::size_t beam = 0; beam < points.size(); ++beam) {
      const double range = static_cast<double>(scan.ranges[beam]);
      const double bearing = scan.bearing(beam);
      EXPECT_EQ(points[beam], Point2(range * std::cos(bearing), range * std::sin(bearing)));
    }
  }
}

TEST(LaserScan, ARangeThatIsNoMeasurementIsNoReturn) {
  for (const float range : {kNoReturn, kInfinite, -kInfinite, -1.0F, 0.0F, 0.05F, 10.5F}) {
    const LaserScan scan = quarter_turns({range});
    EXPECT_FALSE(scan.has_return(0)) << range;
    EXPECT_TRUE(returns_as_points(scan).empty()) << range;
  }
}

TEST(LaserScan, ALidarThatMeasuresFromZeroHasNoReturnAtZero) {
  LaserScan scan = quarter_turns({0.0F});
  scan.range_min = 0.0;
  EXPECT_FALSE(scan.has_return(0));
}

TEST(LaserScan, ARangeAtRangeMinIsAReturn) {
  LaserScan scan = quarter_turns({0.5F});
  scan.range_min = 0.5;
  EXPECT_TRUE(scan.has_return(0));
}

// Drivers report range_max for a beam without a return, rounded to a float or to millimetres.
TEST(LaserScan, ARangeAtRangeMaxOrJustBelowItIsNoReturn) {
  LaserScan scan = quarter_turns({5.6F, 5.599F, 5.58F});
  scan.range_max = 5.6;
  EXPECT_FALSE(scan.has_return(0));
  EXPECT_FALSE(scan.has_return(1));
  EXPECT_TRUE(scan.has_return(2));
  EXPECT_EQ(returns_as_points(scan).size(), 1U);
}

// A SICK S300 reports 29.96 m where its range_max is 30 m.
TEST(LaserScan, ARangeALittleBelowALongRangeMaxIsNoReturn) {
  LaserScan scan = quarter_turns({29.96F, 29.94F});
  scan.range_max = 30.0;
  EXPECT_FALSE(scan.has_return(0));
  EXPECT_TRUE(scan.has_return(1));
}

TEST(LaserScan, IsCutToAFullTurn) {
  LaserScan scan{.angle_increment = -0.0174533, .range_max = 10.0, .ranges = {}};
  scan.ranges.resize(400, 1.0F);
  scan.ranges[359] = 2.0F;
  EXPECT_TRUE(validate(scan).has_value());
  EXPECT_TRUE(cut_to_full_turn(scan));
  EXPECT_EQ(scan.ranges.size(), 360U);
  EXPECT_EQ(scan.ranges.back(), 2.0F);
  EXPECT_FALSE(cut_to_full_turn(scan));
}

TEST(LaserScan, StaysAsItIsWhenItIsFarMoreThanATurn) {
  LaserScan scan{.angle_increment = 1.0, .range_max = 10.0, .ranges = {}};  // Degrees.
  scan.ranges.resize(360, 1.0F);
  EXPECT_FALSE(cut_to_full_turn(scan));
  EXPECT_TRUE(validate(scan).has_value());
}

TEST(LaserScan, HasNoLimitWhenItsRangeMaxIsInfinite) {
  LaserScan scan = quarter_turns({0.5F, 1e6F, std::numeric_limits<float>::infinity()});
  scan.range_max = kInfinity;
  EXPECT_FALSE(validate(scan).has_value());
  EXPECT_TRUE(scan.has_return(1));
  EXPECT_FALSE(scan.has_return(2));
}

TEST(LaserScan, AnEmptyScanIsValid) {
  EXPECT_FALSE(validate(quarter_turns({})).has_value());
  EXPECT_TRUE(returns_as_points(quarter_turns({})).empty());
}

TEST(LaserScan, AFullTurnThatRepeatsItsFirstBearingIsValid) {
  EXPECT_FALSE(validate(quarter_turns({1.0F, 1.0F, 1.0F, 1.0F, 1.0F})).has_value());
}

TEST(LaserScan, BeamsWithoutReturnAreValid) {
  EXPECT_FALSE(validate(quarter_turns({kNoReturn, kInfinite, -1.0F, 99.0F})).has_value());
}

struct BrokenScan {
  const char* field;
  void (*broken)(LaserScan&);
};

class BrokenLaserScan : public ::testing::TestWithParam<BrokenScan> {};

TEST_P(BrokenLaserScan, IsRefusedByTheNameOfTheField) {
  LaserScan scan = quarter_turns({1.0F, 2.0F, 3.0F, 4.0F});
  ASSERT_FALSE(validate(scan).has_value());
  GetParam().broken(scan);
  const auto error = validate(scan);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->field, GetParam().field);
  EXPECT_EQ(error->code, ErrorCode::kInvalidArgument);
  EXPECT_FALSE(error->message.empty());
}

INSTANTIATE_TEST_SUITE_P(
    LaserScan, BrokenLaserScan,
    ::testing::Values(
        BrokenScan{"stamp", [](LaserScan& scan) { scan.stamp = std::nan(""); }},
        BrokenScan{"stamp", [](LaserScan& scan) { scan.stamp = kInfinity; }},
        BrokenScan{"angle_min", [](LaserScan& scan) { scan.angle_min = std::nan(""); }},
        BrokenScan{"angle_min", [](LaserScan& scan) { scan.angle_min = 1e7; }},
        BrokenScan{"angle_increment", [](LaserScan& scan) { scan.angle_increment = 0.0; }},
        BrokenScan{"angle_increment", [](LaserScan& scan) { scan.angle_increment = 1e308; }},
        BrokenScan{"angle_increment", [](LaserScan& scan) { scan.angle_increment = kInfinity; }},
        BrokenScan{"range_min", [](LaserScan& scan) { scan.range_min = -0.1; }},
        BrokenScan{"range_min", [](LaserScan& scan) { scan.range_min = std::nan(""); }},
        BrokenScan{"range_max", [](LaserScan& scan) { scan.range_max = scan.range_min; }},
        BrokenScan{"range_max", [](LaserScan& scan) { scan.range_max = std::nan(""); }},
        BrokenScan{"ranges", [](LaserScan& scan) { scan.ranges.resize(40, 1.0F); }},
        BrokenScan{"ranges", [](LaserScan& scan) {
                     scan.angle_increment = -scan.angle_increment;
                     scan.ranges.resize(7, 1.0F);
                   }}));

}  // namespace
}  // namespace cornerfix

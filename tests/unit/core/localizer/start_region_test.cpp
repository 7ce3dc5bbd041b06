#include <cornerfix/localizer_params.hpp>

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace cornerfix {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The field that `validate` names, or nothing for a sound region.
std::string broken_field(const StartRegion& region) {
  const std::optional<Error> error = validate(region);
  return error ? error->field : "";
}

StartRegion dock() { return {.center = {3.0, -2.0}, .radius_m = 1.5}; }

TEST(StartRegion, IsSoundWithoutAndWithAHeading) {
  StartRegion region = dock();
  EXPECT_EQ(broken_field(region), "");
  region.yaw = -4.0;
  region.yaw_tolerance_rad = std::numbers::pi;
  EXPECT_EQ(broken_field(region), "");
}

TEST(StartRegion, NeedsAFiniteCenter) {
  StartRegion region = dock();
  region.center = {kNan, 0.0};
  EXPECT_EQ(broken_field(region), "x");
  region.center = {0.0, kInfinity};
  EXPECT_EQ(broken_field(region), "y");
}

TEST(StartRegion, NeedsAPositiveRadius) {
  StartRegion region = dock();
  for (const double radius : {0.0, -1.0, kNan, kInfinity}) {
    region.radius_m = radius;
    EXPECT_EQ(broken_field(region), "radius_m") << radius;
  }
}

TEST(StartRegion, NeedsAFiniteHeadingAndATolerance) {
  StartRegion region = dock();
  region.yaw = kNan;
  EXPECT_EQ(broken_field(region), "yaw");
  region.yaw = 0.5;
  for (const double tolerance : {0.0, 3.2, kNan}) {
    region.yaw_tolerance_rad = tolerance;
    EXPECT_EQ(broken_field(region), "yaw_tolerance_rad") << tolerance;
  }
}

}  // namespace
}  // namespace cornerfix

#include <cornerfix/localizer_params.hpp>

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace cornerfix {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// The field that `validate` names, or nothing for a sound region.
std::string region_fault(const StartRegion& region) {
  const std::optional<Error> error = validate(region);
  return error ? error->field : "";
}

StartRegion dock() { return {.center = {3.0, -2.0}, .radius_m = 1.5}; }

TEST(StartRegion, IsSoundWithoutAndWithAHeading) {
  StartRegion region = dock();
  EXPECT_EQ(region_fault(region), "");
  region.yaw = -4.0;
  region.yaw_tolerance_rad = std::numbers::pi;
  EXPECT_EQ(region_fault(region), "");
}

TEST(StartRegion, NeedsAFiniteCenter) {
  StartRegion region = dock();
  region.center = {kNotANumber, 0.0};
  EXPECT_EQ(region_fault(region), "x");
  region.center = {0.0, kUnbounded};
  EXPECT_EQ(region_fault(region), "y");
}

TEST(StartRegion, NeedsAPositiveRadius) {
  StartRegion region = dock();
  for (const double radius : {0.0, -1.0, kNotANumber, kUnbounded}) {
    region.radius_m = radius;
    EXPECT_EQ(region_fault(region), "radius_m") << radius;
  }
}

TEST(StartRegion, NeedsAFiniteHeadingAndATolerance) {
  StartRegion region = dock();
  region.yaw = kNotANumber;
  EXPECT_EQ(region_fault(region), "yaw");
  region.yaw = 0.5;
  for (const double tolerance : {0.0, 3.2, kNotANumber}) {
    region.yaw_tolerance_rad = tolerance;
    EXPECT_EQ(region_fault(region), "yaw_tolerance_rad") << tolerance;
  }
}

}  // namespace
}  // namespace cornerfix

/// \file  What tests compare by: poses within metres and radians, points within metres.
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <ostream>

#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// GoogleTest finds it by argument-dependent look-up.
inline void PrintTo(const Pose2& pose, std::ostream* out) {
  *out << "(" << pose.x << " m, " << pose.y << " m, " << pose.yaw << " rad)";
}

namespace testing {

MATCHER_P3(IsPoseNear, expected, metres, radians,
           "is within " + ::testing::PrintToString(metres) + " m and " +
               ::testing::PrintToString(radians) + " rad of " +
               ::testing::PrintToString(expected)) {
  const double metres_off = distance(arg, expected);
  const double radians_off = angle_between(arg, expected);
  *result_listener << "off by " << metres_off << " m and " << radians_off << " rad";
  return metres_off <= metres && radians_off <= radians;
}

MATCHER_P2(IsPointNear, expected, metres,
           "is within " + ::testing::PrintToString(metres) + " m of (" +
               ::testing::PrintToString(expected.x()) + ", " +
               ::testing::PrintToString(expected.y()) + ")") {
  const double metres_off = (arg - expected).norm();
  *result_listener << "off by " << metres_off << " m";
  return metres_off <= metres;
}

}  // namespace testing
}  // namespace cornerfix

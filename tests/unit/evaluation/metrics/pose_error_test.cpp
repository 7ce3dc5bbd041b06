#include "evaluation/metrics/pose_error.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace cornerfix::evaluation {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(PoseError, IsCorrectWithinHalfAMetreAndFiveDegrees) {
  EXPECT_TRUE(is_correct({0.5, 5.0 * kDegree}));
  EXPECT_FALSE(is_correct({0.501, 0.0}));
  EXPECT_FALSE(is_correct({0.0, 5.01 * kDegree}));
}

TEST(PoseError, AllowsALargerAngleBetweenKeyframes) {
  EXPECT_TRUE(is_correct({0.1, 14.9 * kDegree}, kCorrectAngleBetweenKeyframes));
  EXPECT_FALSE(is_correct({0.1, 15.1 * kDegree}, kCorrectAngleBetweenKeyframes));
}

TEST(PoseError, MeasuresTheAngleOverTheCut) {
  const PoseError error = pose_error({1.0, 2.0, 179.0 * kDegree}, {1.3, 2.4, -179.0 * kDegree});
  EXPECT_NEAR(error.m, 0.5, 1e-12);
  EXPECT_NEAR(error.rad, 2.0 * kDegree, 1e-12);
}

}  // namespace
}  // namespace cornerfix::evaluation

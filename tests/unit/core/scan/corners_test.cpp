#include <cornerfix/corners.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/matchers.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::IsPointNear;
using testing::SceneBuilder;
using testing::simulate_scan;

class EveryExtractor : public ::testing::TestWithParam<CornerExtractor> {};

INSTANTIATE_TEST_SUITE_P(Names, EveryExtractor,
                         ::testing::Values(CornerExtractor::kLineIntersection,
                                           CornerExtractor::kVfp),
                         [](const auto& extractor) {
                           return std::string(to_string(extractor.param));
                         });

TEST_P(EveryExtractor, IsKnownByItsName) {
  EXPECT_EQ(corner_extractor_from_string(to_string(GetParam())), GetParam());
}

TEST_P(EveryExtractor, FindsTheFourCornersOfARoom) {
  const auto scan = simulate_scan(SceneBuilder().room({-4, -3}, {4, 3}), {}, {0.5, 0.2, 0.1});
  const auto corners = extract_corners(scan, GetParam());
  EXPECT_EQ(corners.size(), 4U);
  EXPECT_TRUE(std::ranges::none_of(corners, &Feature::convex));
}

TEST_P(EveryExtractor, TellsWhatJutsOut) {
  const auto scan =
      simulate_scan(SceneBuilder().wall({3, 0}, {6, 1.5}).wall({3, 0}, {6, -1.5}), {}, {});
  const auto corners = extract_corners(scan, GetParam());
  ASSERT_EQ(corners.size(), 1U);
  EXPECT_THAT(corners[0].position, IsPointNear(Point2(3.0, 0.0), 0.02));
  EXPECT_TRUE(corners[0].convex);
}

TEST(CornerExtractor, TellsTheSigmaOfTwoArms) {
  const auto scan = simulate_scan(SceneBuilder().room({-4, -3}, {4, 3}), {}, {0.5, 0.2, 0.1});
  for (const Feature& corner : extract_corners(scan, CornerExtractor::kLineIntersection)) {
    EXPECT_GT(corner.sigma_m, 1e-4);
    EXPECT_LT(corner.sigma_m, 0.01);
  }
  for (const Feature& corner : extract_corners(scan, CornerExtractor::kVfp))
    EXPECT_EQ(corner.sigma_m, 0.0);
}

TEST(CornerExtractor, HasNoOtherName) { EXPECT_FALSE(corner_extractor_from_string("sift")); }

}  // namespace
}  // namespace cornerfix

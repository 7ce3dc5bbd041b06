#include "core/src/features/feature_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using testing::IsPointNear;

Feature corner(double x, double y, double weight = 1.0) {
  return {.position = {x, y}, .turn_angle = weight, .weight = weight};
}

void insert(FeatureMap& map, const Feature& feature) { map.insert(std::vector{feature}); }

TEST(FeatureMap, CountsACornerOnceAScan) {
  FeatureMap map;
  map.insert(std::vector{corner(1.0, 2.0), corner(1.1, 2.0)});
  map.insert(std::vector{corner(1.0, 2.1)});
  ASSERT_EQ(map.features().size(), 1U);
  EXPECT_EQ(map.features()[0].count, 2);
}

TEST(FeatureMap, KeepsThePlaceOfTheStrongerCorner) {
  FeatureMap map;
  insert(map, corner(1.0, 2.0, 1.2));
  insert(map, corner(1.2, 2.0, 1.0));
  EXPECT_THAT(map.features()[0].position, IsPointNear(Point2(1.0, 2.0), 0.0));
  insert(map, corner(0.9, 2.0, 1.4));
  EXPECT_THAT(map.features()[0].position, IsPointNear(Point2(0.9, 2.0), 0.0));
  EXPECT_EQ(map.features()[0].turn_angle, 1.4);
  EXPECT_EQ(map.features()[0].count, 3);
}

TEST(FeatureMap, KeepsCornersApartThatAreFartherThanTheRadius) {
  FeatureMap map({.suppression_radius_m = 0.5});
  map.insert(std::vector{corner(0.0, 0.0), corner(0.51, 0.0)});
  EXPECT_EQ(map.features().size(), 2U);
}

TEST(FeatureMap, JoinsFeaturesThatAStrongerCornerLiesBetween) {
  FeatureMap map({.suppression_radius_m = 0.5});
  insert(map, corner(0.0, 0.0));
  insert(map, corner(0.6, 0.0));
  insert(map, corner(9.0, 9.0));
  insert(map, corner(0.3, 0.0, 2.0));
  ASSERT_EQ(map.features().size(), 2U);
  EXPECT_THAT(map.features()[0].position, IsPointNear(Point2(0.3, 0.0), 0.0));
  EXPECT_EQ(map.features()[0].count, 3);
  EXPECT_THAT(map.features()[1].position, IsPointNear(Point2(9.0, 9.0), 0.0));
}

TEST(FeatureMap, NeverCountsMoreScansThanThereWere) {
  FeatureMap map({.suppression_radius_m = 0.5});
  map.insert(std::vector{corner(0.0, 0.0), corner(0.6, 0.0)});
  map.insert(std::vector{corner(0.0, 0.0), corner(0.6, 0.0), corner(0.3, 0.0, 2.0)});
  ASSERT_EQ(map.features().size(), 1U);
  EXPECT_EQ(map.features()[0].count, 2);
}

TEST(FeatureMap, FindsNeighborsAcrossCellsAndBelowZero) {
  FeatureMap map;
  insert(map, corner(-0.01, -0.01));
  insert(map, corner(0.01, 0.01));
  EXPECT_EQ(map.features().size(), 1U);
}

TEST(FeatureMap, ReturnsOnlyWhatEnoughScansHaveShown) {
  FeatureMap map;
  map.insert(std::vector{corner(0.0, 0.0), corner(5.0, 0.0)});
  map.insert(std::vector{corner(5.0, 0.1)});
  ASSERT_EQ(map.repeated(2).size(), 1U);
  EXPECT_EQ(map.repeated(2)[0].position.x(), 5.0);
  EXPECT_EQ(map.repeated(1).size(), 2U);
  EXPECT_TRUE(map.repeated(3).empty());
}

TEST(FeatureMap, NeverHoldsTwoFeaturesWithinTheRadius) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-3.0, 3.0);
  std::uniform_real_distribution<double> weight(0.5, 1.5);
  FeatureMap map;
  for (int scan = 0; scan < 200; ++scan) {
    std::vector<Feature> corners;
    for (int i = 0; i < 10; ++i) {
      corners.push_back(corner(coordinate(random), coordinate(random), weight(random)));
    }
    map.insert(corners);
  }
  const auto& features = map.features();
  ASSERT_GT(features.size(), 50U);
  for (std::size_t i = 0; i < features.size(); ++i) {
    EXPECT_LE(features[i].count, 200);
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT((features[i].position - features[j].position).norm(), 0.35) << i << " " << j;
    }
  }
}

TEST(FeatureMap, HoldsTheStrongestCornerOfEveryNeighborhood) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> coordinate(-2.0, 2.0);
  FeatureMap map;
  Feature strongest = corner(0.0, 0.0, 0.0);
  for (int scan = 0; scan < 500; ++scan) {
    std::uniform_real_distribution<double> weight(0.5, 1.5);
    const Feature seen = corner(coordinate(random), coordinate(random), weight(random));
    if (seen.weight > strongest.weight) strongest = seen;
    insert(map, seen);
  }
  EXPECT_THAT(map.features(),
              ::testing::Contains(::testing::Field(&Feature::position, strongest.position)));
}

/// A corner whose sigma is known, as from a line intersection.
Feature measured(const Point2& position, double sigma_m, double bisector = 0.0,
                 bool convex = false) {
  return {.position = position,
          .turn_angle = 1.5,
          .bisector = bisector,
          .weight = 1.5,
          .convex = convex,
          .sigma_m = sigma_m};
}

TEST(FeatureMap, AveragesACornerSeenAgainByItsVariance) {
  FeatureMap map;
  insert(map, measured({1.0, 2.0}, 0.02, 3.1));
  insert(map, measured({1.1, 2.0}, 0.01, -3.1));
  ASSERT_EQ(map.features().size(), 1U);
  const Feature& mean = map.features()[0];
  EXPECT_THAT(mean.position, IsPointNear(Point2(1.08, 2.0), 1e-12));
  EXPECT_NEAR(mean.bisector, wrap_angle(3.1 + 0.8 * (2.0 * std::numbers::pi - 6.2)), 1e-12);
  EXPECT_NEAR(mean.sigma_m, 0.01 / std::sqrt(1.25), 1e-12);
  EXPECT_EQ(mean.count, 2);
}

TEST(FeatureMap, NearsTheTruePlaceWithEveryScan) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> noise(0.0, 0.03);
  FeatureMap map;
  for (int scan = 0; scan < 400; ++scan)
    insert(map, measured({5.0 + noise(random), -2.0 + noise(random)}, 0.03));
  ASSERT_EQ(map.features().size(), 1U);
  EXPECT_THAT(map.features()[0].position, IsPointNear(Point2(5.0, -2.0), 0.006));
  EXPECT_NEAR(map.features()[0].sigma_m, 0.0015, 1e-6);
  EXPECT_EQ(map.features()[0].count, 400);
}

TEST(FeatureMap, DoesNotAverageCornersOfAnotherSenseOrDirection) {
  for (const Feature& other :
       {measured({0.1, 0.0}, 0.01, 0.0, true), measured({0.1, 0.0}, 0.01, 1.5)}) {
    FeatureMap map;
    insert(map, measured({0.0, 0.0}, 0.01));
    insert(map, other);
    ASSERT_EQ(map.features().size(), 1U);
    EXPECT_EQ(map.features()[0].position, Point2(0.0, 0.0));
    EXPECT_EQ(map.features()[0].sigma_m, 0.01);
  }
}

TEST(FeatureMap, KeepsItsDistancesWhenAMeanMoves) {
  FeatureMap map({.suppression_radius_m = 0.5});
  insert(map, measured({0.0, 0.0}, 0.01));
  insert(map, measured({0.6, 0.0}, 0.01, 2.0));
  insert(map, measured({0.4, 0.0}, 0.01));
  ASSERT_EQ(map.features().size(), 2U);
  EXPECT_EQ(map.features()[0].position, Point2(0.0, 0.0));
  EXPECT_EQ(map.features()[0].count, 2);
}

TEST(FeatureMap, RefusesARadiusOfNothing) {
  EXPECT_EQ(validate(FeatureMapParams{.suppression_radius_m = 0.0})->field, "suppression_radius_m");
  EXPECT_FALSE(validate(FeatureMapParams{}));
}

TEST(Feature, TurnsWithItsFrame) {
  const Feature moved = transformed({1.0, 2.0, 3.0}, {.position = {1.0, 0.0}, .bisector = 1.0});
  EXPECT_THAT(moved.position, IsPointNear(Point2(1.0 + std::cos(3.0), 2.0 + std::sin(3.0)), 1e-12));
  EXPECT_NEAR(moved.bisector, wrap_angle(4.0), 1e-12);
}

}  // namespace
}  // namespace cornerfix

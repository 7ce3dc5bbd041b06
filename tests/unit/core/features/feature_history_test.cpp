#include "core/src/features/feature_history.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include <cornerfix/corners.hpp>

#include "support/matchers.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::IsPointNear;
using testing::SceneBuilder;

/// A room with a cupboard in the middle of a wall, or where it stood before.
SceneBuilder empty_room() { return SceneBuilder().room({0, 0}, {8, 6}); }
SceneBuilder furnished(const Point2& cupboard) { return empty_room().box(cupboard, {1.2, 1.0}); }

const Point2 kBefore{4.0, 4.5};
const Point2 kAfter{4.0, 1.5};

/// Once across the room below `y` = 3.
class FeatureHistoryTest : public ::testing::Test {
 protected:
  void drive(const SceneBuilder& scene, std::size_t scans, double y = 3.0,
             const Pose2& T_map_told = {}) {
    for (std::size_t i = 0; i < scans; ++i) {
      const Pose2 pose{1.0 + 6.0 * static_cast<double>(i) / static_cast<double>(scans), y, 0.1};
      const LaserScan scan =
          testing::simulate_scan(scene, {.beams = 720, .noise_m = 0.005}, pose, random_);
      std::vector<Feature> corners = extract_corners(scan, CornerExtractor::kLineIntersection);
      for (Feature& corner : corners) corner = transformed(T_map_told * pose, corner);
      history_.insert(corners, scan, T_map_told * pose);
    }
  }

  [[nodiscard]] const Feature* near(const Point2& place, double radius = 0.1) {
    features_ = history_.repeated();
    for (const Feature& feature : features_) {
      if ((feature.position - place).norm() < radius) return &feature;
    }
    return nullptr;
  }
  /// Of the side of the cupboard that looks to the middle of the room.
  static Point2 corner_of(const Point2& cupboard) {
    return cupboard + Point2(0.6, cupboard.y() > 3.0 ? -0.5 : 0.5);
  }

  FeatureHistory history_{FeatureMapParams{}, 2};
  std::mt19937_64 random_{4};
  std::vector<Feature> features_;
};

TEST_F(FeatureHistoryTest, IsAFeatureMapDuringTheFirstDrive) {
  drive(furnished(kBefore), 12);
  FeatureMap map;
  random_.seed(4);
  for (std::size_t i = 0; i < 12; ++i) {
    const Pose2 pose{1.0 + 6.0 * static_cast<double>(i) / 12.0, 3.0, 0.1};
    std::vector<Feature> corners = extract_corners(
        testing::simulate_scan(furnished(kBefore), {.beams = 720, .noise_m = 0.005}, pose, random_),
        CornerExtractor::kLineIntersection);
    for (Feature& corner : corners) corner = transformed(pose, corner);
    map.insert(corners);
  }
  const std::vector<Feature> expected = map.repeated(2);
  const std::vector<Feature> actual = history_.repeated();
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(actual[i].position, expected[i].position);
    EXPECT_EQ(actual[i].count, expected[i].count);
  }
}

TEST_F(FeatureHistoryTest, WhatALaterDriveLooksThroughIsGone) {
  drive(furnished(kBefore), 20);
  ASSERT_NE(near(corner_of(kBefore)), nullptr);
  history_.begin_drive();
  drive(empty_room(), 20);
  EXPECT_EQ(near(corner_of(kBefore), 0.3), nullptr);
  EXPECT_NE(near({8.0, 6.0}), nullptr);
}

TEST_F(FeatureHistoryTest, AFewScansDoNotDisproveAFeature) {
  drive(furnished(kBefore), 20);
  history_.begin_drive();
  drive(empty_room(), 9);
  EXPECT_NE(near(corner_of(kBefore)), nullptr);
}

TEST_F(FeatureHistoryTest, WhatIsNewIsThereAfterAsManyScansAsEver) {
  drive(furnished(kBefore), 20);
  history_.begin_drive();
  drive(furnished(kAfter), 20);
  EXPECT_NE(near(corner_of(kAfter)), nullptr);
}

TEST_F(FeatureHistoryTest, WhatALaterDriveDoesNotComeByStays) {
  drive(furnished(kBefore), 20);
  const std::size_t before = history_.repeated().size();
  history_.begin_drive();
  const SceneBuilder elsewhere = empty_room().moved({100.0, 0.0, 0.0});
  drive(elsewhere, 0);
  const LaserScan scan = testing::simulate_scan(elsewhere, {.beams = 720}, {104.0, 3.0, 0.0});
  for (int i = 0; i < 30; ++i) history_.insert({}, scan, {104.0, 3.0, 0.0});
  EXPECT_EQ(history_.repeated().size(), before);
}

TEST_F(FeatureHistoryTest, AFeatureShownAgainStandsWhereTheLaterDriveSawItAndKeepsItsCount) {
  drive(furnished(kBefore), 20);
  const int count = near({8.0, 6.0})->count;
  history_.begin_drive();
  drive(furnished(kBefore), 20, 3.0, {0.06, -0.04, 0.0});
  const Feature* again = near(Point2{8.06, 5.96}, 0.03);
  ASSERT_NE(again, nullptr);
  EXPECT_GT(again->count, count);
  EXPECT_EQ(near({8.0, 6.0}, 0.03), nullptr);
}

TEST_F(FeatureHistoryTest, DoesNotGrowWhenTheSameBuildingIsMappedAgainAndAgain) {
  drive(furnished(kBefore), 20);
  const std::size_t once = history_.repeated().size();
  for (int again = 0; again < 5; ++again) {
    history_.begin_drive();
    drive(furnished(kBefore), 20, 3.0, {0.05 * (again % 2), 0.04 * (again % 3), 0.002 * again});
  }
  EXPECT_LE(history_.repeated().size(), once + 2);
}

TEST_F(FeatureHistoryTest, ScansWithoutReturnsDisproveNothing) {
  drive(furnished(kBefore), 20);
  const std::size_t before = history_.repeated().size();
  history_.begin_drive();
  LaserScan dark = testing::simulate_scan(empty_room(), {.beams = 720}, {4.0, 3.0, 0.0});
  for (float& range : dark.ranges) range = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 30; ++i) history_.insert({}, dark, {4.0, 3.0, 0.0});
  history_.insert({}, LaserScan{}, {4.0, 3.0, 0.0});
  EXPECT_EQ(history_.repeated().size(), before);
}

}  // namespace
}  // namespace cornerfix

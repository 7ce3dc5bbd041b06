#include <cornerfix/corners.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "support/random_features.hpp"

namespace cornerfix {
namespace {

using testing::random_features;

using std::numbers::pi;

std::vector<Feature> features_at(std::initializer_list<Point2> positions) {
  std::vector<Feature> features;
  for (const Point2& position : positions) features.push_back({.position = position});
  return features;
}

/// Distance and angle bin by the other feature's index.
std::map<std::uint32_t, std::pair<int, int>> by_feature(std::span<const DescriptorEntry> entries) {
  std::map<std::uint32_t, std::pair<int, int>> result;
  for (const DescriptorEntry& e : entries) result[e.feature] = {e.distance_bin, e.angle_bin};
  return result;
}

/// Algorithm 2, line by line.
std::map<std::uint32_t, std::pair<int, int>> described_by_hand(std::span<const Feature> features,
                                                               std::size_t i,
                                                               const DescriptorParams& params) {
  std::map<std::uint32_t, std::pair<int, int>> result;
  for (std::size_t j = 0; j < features.size(); ++j) {
    const Point2 v = features[j].position - features[i].position;
    if (j == i || v.norm() > params.max_distance_m) continue;
    const double from_x = std::acos(v.x() / v.norm());
    const double bearing = v.y() > 0.0 ? from_x : 2.0 * pi - from_x;
    const int bins = static_cast<int>(std::lround(2.0 * pi / params.angle_resolution_rad));
    result[static_cast<std::uint32_t>(j)] = {
        static_cast<int>(std::lround(v.norm() / params.distance_resolution_m)),
        static_cast<int>(std::lround(bearing / params.angle_resolution_rad)) % bins};
  }
  return result;
}

TEST(Descriptor, AgreesWithAlgorithm2LineByLine) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    std::mt19937_64 random(seed);
    const auto features = random_features(60, 50.0, random);
    const DescriptorSet set = describe(features, {});
    ASSERT_EQ(set.size(), features.size());
    for (std::size_t i = 0; i < set.size(); ++i) {
      EXPECT_EQ(by_feature(set[i]), described_by_hand(features, i, {})) << seed << " " << i;
    }
  }
}

TEST(Descriptor, IsAscendingInDistance) {
  std::mt19937_64 random(1);
  const DescriptorSet set = describe(random_features(80, 40.0, random), {});
  for (std::size_t i = 0; i < set.size(); ++i) {
    EXPECT_TRUE(std::ranges::is_sorted(set[i], {}, &DescriptorEntry::distance_bin));
  }
}

TEST(Descriptor, LeavesOutWhatIsFartherThanTheMaximum) {
  const auto features = features_at({{0, 0}, {9.9, 0}, {20.1, 0}});
  const DescriptorSet set = describe(features, {.max_distance_m = 10.0});
  EXPECT_EQ(set[0].size(), 1U);
  EXPECT_EQ(set[1].size(), 1U);
  EXPECT_TRUE(set[2].empty());
}

TEST(Descriptor, CountsBearingsFromTheXAxisOverAFullTurn) {
  const auto features = features_at({{0, 0}, {5, 0}, {0, 5}, {-5, 0}, {0, -5}});
  const auto bins = by_feature(describe(features, {})[0]);
  EXPECT_EQ(bins.at(1), std::pair(25, 0));
  EXPECT_EQ(bins.at(2), std::pair(25, 30));
  EXPECT_EQ(bins.at(3), std::pair(25, 60));
  EXPECT_EQ(bins.at(4), std::pair(25, 90));
}

TEST(Descriptor, RoundsABearingJustBelowAFullTurnToTheFirstBin) {
  const auto features = features_at({{0, 0}, {10.0, -0.1}, {10.0, -0.4}});
  const auto bins = by_feature(describe(features, {})[0]);
  EXPECT_EQ(bins.at(1).second, 0);
  EXPECT_EQ(bins.at(2).second, 119);
}

TEST(Descriptor, KeepsTwoFeaturesInOnePlaceApart) {
  const DescriptorSet set = describe(features_at({{1, 1}, {1, 1}, {4, 1}}), {});
  EXPECT_EQ(set[0].size(), 2U);
  EXPECT_EQ(set[0][0].distance_bin, 0);
}

TEST(Descriptor, OfNoneOrOneFeatureIsEmpty) {
  EXPECT_EQ(describe({}, {}).size(), 0U);
  const DescriptorSet one = describe(features_at({{1, 1}}), {});
  ASSERT_EQ(one.size(), 1U);
  EXPECT_TRUE(one[0].empty());
}

TEST(Descriptor, WorksWithAnOddNumberOfAngleBins) {
  std::mt19937_64 random(4);
  const auto features = random_features(30, 20.0, random);
  const DescriptorParams params{.angle_resolution_rad = 2.0 * pi / 45.0};
  const DescriptorSet set = describe(features, params);
  EXPECT_EQ(set.angle_bins(), 45);
  for (std::size_t i = 0; i < set.size(); ++i) {
    EXPECT_EQ(by_feature(set[i]), described_by_hand(features, i, params));
  }
}

TEST(Descriptor, OfOneFeatureIsThatOfAll) {
  std::mt19937_64 random(3);
  std::vector<Feature> features = testing::random_features(60, 30.0, random);
  features[7].position.x() = features[8].position.x();  // a pair that only their order sorts
  const DescriptorParams params{.max_distance_m = 12.0};
  const DescriptorSet all = describe(features, params);
  for (std::size_t i = 0; i < features.size(); ++i) {
    const auto one = describe_one(features, i, params);
    EXPECT_THAT(one, ::testing::UnorderedElementsAreArray(all[i])) << "feature " << i;
    EXPECT_TRUE(std::ranges::is_sorted(one, {}, &DescriptorEntry::distance_bin));
  }
}

TEST(Descriptor, StaysSmallOnALargeMap) {
  std::mt19937_64 random(5);
  const DescriptorSet set = describe(random_features(5000, 500.0, random), {});
  EXPECT_LT(set.entries.size() * sizeof(DescriptorEntry), 3'000'000U);
}

TEST(DescriptorParams, NameTheBrokenLimit) {
  EXPECT_FALSE(validate(DescriptorParams{}));
  EXPECT_EQ(validate(DescriptorParams{.distance_resolution_m = 0.0})->field,
            "distance_resolution_m");
  EXPECT_EQ(validate(DescriptorParams{.angle_resolution_rad = 0.07})->field,
            "angle_resolution_rad");
  EXPECT_EQ(validate(DescriptorParams{.angle_resolution_rad = -1.0})->field,
            "angle_resolution_rad");
  EXPECT_EQ(validate(DescriptorParams{.max_distance_m = 1e6})->field, "max_distance_m");
}

}  // namespace
}  // namespace cornerfix

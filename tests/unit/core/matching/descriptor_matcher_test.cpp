#include "core/src/matching/descriptor_matcher.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

#include "support/random_features.hpp"

namespace cornerfix {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::random_features;
using testing::seen_again;
using ::testing::UnorderedElementsAreArray;

constexpr int kBins = 120;

/// Votes of two descriptors by angle bin, every entry against every other.
std::vector<int> votes_by_hand(std::span<const DescriptorEntry> local,
                               std::span<const DescriptorEntry> global, int angle_bins) {
  std::vector<int> votes(static_cast<std::size_t>(angle_bins), 0);
  for (const DescriptorEntry& m : local) {
    for (const DescriptorEntry& n : global) {
      if (m.distance_bin != n.distance_bin) continue;
      const int bin = (m.angle_bin - n.angle_bin + angle_bins) % angle_bins;
      ++votes[static_cast<std::size_t>(bin)];
    }
  }
  return votes;
}

/// What match_exhaustive() promises, the slow way.
std::vector<DescriptorMatch> matches_by_hand(const DescriptorSet& local,
                                             const DescriptorSet& global, int min_votes,
                                             std::size_t max_matches) {
  std::vector<DescriptorMatch> all;
  for (std::uint32_t i = 0; i < local.size(); ++i) {
    for (std::uint32_t j = 0; j < global.size(); ++j) {
      const auto votes = votes_by_hand(local[i], global[j], local.angle_bins());
      const auto fullest = std::ranges::max_element(votes);
      if (*fullest > min_votes) {
        all.push_back({i, j, static_cast<int>(fullest - votes.begin()), *fullest});
      }
    }
  }
  std::ranges::sort(all, {}, [](const DescriptorMatch& m) {
    return std::tuple(-m.votes, m.global_feature, m.local_feature);
  });
  std::set<std::pair<std::uint32_t, int>> taken;
  std::vector<DescriptorMatch> best;
  for (const DescriptorMatch& match : all) {
    if (best.size() < max_matches && taken.emplace(match.global_feature, match.angle_bin).second) {
      best.push_back(match);
    }
  }
  return best;
}

/// A map and a submap that shares half of its features with it.
struct Maps {
  std::vector<Feature> local;
  std::vector<Feature> global;
  std::size_t shared = 0;  ///< local[i] is global[i] for i below this.
};

Maps overlapping_maps(std::size_t count, double side_m, double noise_m, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Maps maps;
  maps.shared = count / 2;
  maps.global = random_features(count, side_m, random);
  std::uniform_real_distribution<double> pose(-3.0, 3.0);
  const Pose2 T_submap_map{10.0 * pose(random), 10.0 * pose(random), pose(random)};
  maps.local = seen_again(std::span(maps.global).first(maps.shared), T_submap_map, noise_m, random);
  for (Feature& other : random_features(count - maps.shared, side_m, random)) {
    maps.local.push_back(transformed(T_submap_map, other));
  }
  return maps;
}

std::vector<DescriptorEntry> entries(std::initializer_list<std::pair<int, int>> bins) {
  std::vector<DescriptorEntry> result;
  for (const auto& [d, a] : bins) {
    result.push_back({static_cast<std::uint16_t>(d), static_cast<std::uint16_t>(a),
                      static_cast<std::uint32_t>(result.size())});
  }
  return result;
}

TEST(MatchDescriptors, VotesForOneRotation) {
  const auto local = entries({{5, 30}, {7, 50}, {9, 90}, {11, 3}});
  const auto global = entries({{5, 20}, {7, 40}, {8, 80}, {9, 80}, {11, 60}});
  EXPECT_THAT(match_descriptors(local, global, kBins, 2),
              ElementsAre(std::pair(0U, 0U), std::pair(1U, 1U), std::pair(2U, 3U)));
}

TEST(MatchDescriptors, TakesAnglesRoundTheSeam) {
  const auto local = entries({{5, 2}, {7, 119}});
  const auto global = entries({{5, 118}, {7, 115}});
  EXPECT_THAT(match_descriptors(local, global, kBins, 1),
              ElementsAre(std::pair(0U, 0U), std::pair(1U, 1U)));
}

TEST(MatchDescriptors, PairsAllEntriesOfEqualDistance) {
  const auto local = entries({{5, 10}, {5, 10}, {6, 0}});
  const auto global = entries({{5, 0}, {5, 0}});
  EXPECT_EQ(match_descriptors(local, global, kBins, 3).size(), 4U);
}

TEST(MatchDescriptors, AsksForMoreThanTheThreshold) {
  const auto same = entries({{5, 30}, {7, 50}, {9, 90}});
  EXPECT_EQ(match_descriptors(same, same, kBins, 2).size(), 3U);
  EXPECT_THAT(match_descriptors(same, same, kBins, 3), IsEmpty());
}

TEST(MatchDescriptors, FindsNothingInEmptyDescriptors) {
  const auto some = entries({{5, 30}});
  EXPECT_THAT(match_descriptors(some, {}, kBins, 0), IsEmpty());
  EXPECT_THAT(match_descriptors({}, some, kBins, 0), IsEmpty());
}

TEST(MatchDescriptors, AgreesWithBruteForce) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Maps maps = overlapping_maps(40, 15.0, 0.02, seed);
    const DescriptorSet local = describe(maps.local, {});
    const DescriptorSet global = describe(maps.global, {});
    for (std::size_t i = 0; i < local.size(); i += 7) {
      for (std::size_t j = 0; j < global.size(); ++j) {
        const auto votes = votes_by_hand(local[i], global[j], kBins);
        const auto pairs = match_descriptors(local[i], global[j], kBins, 0);
        EXPECT_EQ(static_cast<int>(pairs.size()), *std::ranges::max_element(votes))
            << "seed " << seed << " descriptors " << i << ", " << j;
      }
    }
  }
}

TEST(MatchExhaustive, AgreesWithBruteForce) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    for (const double side_m : {5.0, 40.0}) {
      // More features than fit one block of the index.
      const Maps maps = overlapping_maps(70, side_m, 0.03, seed);
      const DescriptorSet local = describe(maps.local, {});
      const DescriptorSet global = describe(maps.global, {});
      auto expected = matches_by_hand(local, global, 4, 100000);
      for (const std::size_t max_matches : {100000U, 20U, 1U}) {
        expected.resize(std::min(expected.size(), max_matches));
        EXPECT_EQ(match_exhaustive(local, global, 4, max_matches), expected)
            << "seed " << seed << " side " << side_m << " matches " << max_matches;
      }
    }
  }
}

TEST(MatchExhaustive, AgreesWithBruteForceOnDuplicateFeatures) {
  Maps maps = overlapping_maps(30, 10.0, 0.0, 1);
  maps.local.insert(maps.local.end(), maps.local.begin(), maps.local.begin() + 10);
  maps.global.insert(maps.global.end(), maps.global.begin(), maps.global.begin() + 20);
  const DescriptorSet local = describe(maps.local, {});
  const DescriptorSet global = describe(maps.global, {});
  EXPECT_EQ(match_exhaustive(local, global, 0, 500), matches_by_hand(local, global, 0, 500));
}

TEST(MatchExhaustive, AgreesWithBruteForceAtOtherResolutions) {
  const Maps maps = overlapping_maps(40, 20.0, 0.01, 3);
  for (const int bins : {1, 7, 360, 4096}) {
    const DescriptorParams params{.distance_resolution_m = 0.5,
                                  .angle_resolution_rad = 2.0 * std::numbers::pi / bins};
    const DescriptorSet local = describe(maps.local, params);
    const DescriptorSet global = describe(maps.global, params);
    EXPECT_EQ(match_exhaustive(local, global, 2, 50), matches_by_hand(local, global, 2, 50))
        << bins;
  }
}

TEST(MatchExhaustive, TellsTheRotationAcrossTheSeam) {
  std::mt19937_64 random(2);
  const auto global = random_features(40, 20.0, random);
  for (const double degrees : {-178.5, -90.0, -1.5, 0.0, 3.0, 90.0, 177.0, 180.0}) {
    const double yaw = degrees * std::numbers::pi / 180.0;
    const auto local = seen_again(global, {0.0, 0.0, yaw}, 0.0, random);
    const auto matches = match_exhaustive(describe(local, {}), describe(global, {}), 10, 1);
    ASSERT_EQ(matches.size(), 1U);
    const double found = matches[0].angle_bin * 3.0 * std::numbers::pi / 180.0;
    EXPECT_LT(std::abs(wrap_angle(found - yaw)), 3.1 * std::numbers::pi / 180.0) << degrees;
  }
}

TEST(MatchExhaustive, FindsTheSamePairsInWhateverOrderTheFeaturesCome) {
  const Maps maps = overlapping_maps(60, 30.0, 0.01, 5);
  std::vector<std::size_t> order(maps.global.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::mt19937_64 random(6);
  std::shuffle(order.begin(), order.end(), random);
  std::vector<Feature> shuffled;
  for (const std::size_t i : order) shuffled.push_back(maps.global[i]);

  const DescriptorSet local = describe(maps.local, {});
  std::vector<std::tuple<std::uint32_t, std::size_t, int, int>> plain;
  for (const auto& m : match_exhaustive(local, describe(maps.global, {}), 6, 100000)) {
    plain.emplace_back(m.local_feature, m.global_feature, m.angle_bin, m.votes);
  }
  std::vector<std::tuple<std::uint32_t, std::size_t, int, int>> mixed;
  for (const auto& m : match_exhaustive(local, describe(shuffled, {}), 6, 100000)) {
    mixed.emplace_back(m.local_feature, order[m.global_feature], m.angle_bin, m.votes);
  }
  ASSERT_FALSE(plain.empty());
  EXPECT_THAT(mixed, UnorderedElementsAreArray(plain));
}

TEST(MatchExhaustive, FindsNothingInEmptyMaps) {
  const DescriptorSet some = describe(overlapping_maps(10, 5.0, 0.0, 1).local, {});
  EXPECT_THAT(match_exhaustive(some, DescriptorSet{}, 0, 10), IsEmpty());
  EXPECT_THAT(match_exhaustive(describe({}, {}), some, 0, 10), IsEmpty());
  EXPECT_THAT(match_exhaustive(some, some, 0, 0), IsEmpty());
  EXPECT_THAT(match_sampled(describe({}, {}), some, 0, 10, {}), IsEmpty());
}

TEST(MatchSampled, IsExhaustiveWhenAllAreDrawn) {
  const Maps maps = overlapping_maps(40, 20.0, 0.02, 4);
  const DescriptorSet local = describe(maps.local, {});
  const DescriptorSet global = describe(maps.global, {});
  const SampledMatchParams all{.success_probability = 0.999, .overlap = 0.001};
  EXPECT_EQ(match_sampled(local, global, 3, 50, all), match_exhaustive(local, global, 3, 50));
}

TEST(MatchSampled, DrawsTheSameForTheSameSeedAndOthersForAnother) {
  const Maps maps = overlapping_maps(40, 20.0, 0.02, 4);
  const DescriptorSet local = describe(maps.local, {});
  const DescriptorSet global = describe(maps.global, {});
  const auto drawn = [&](std::uint64_t seed) {
    return match_sampled(local, global, 0, 1000, {.seed = seed});
  };
  EXPECT_EQ(drawn(1), drawn(1));
  EXPECT_NE(drawn(1), drawn(2));
}

TEST(MatchSampled, DrawsEachLocalDescriptorOnceAndAllAlike) {
  const Maps maps = overlapping_maps(20, 20.0, 0.0, 4);
  const DescriptorSet local = describe(maps.local, {});
  const DescriptorSet global = describe(maps.global, {});
  std::vector<int> draws(local.size(), 0);
  constexpr int kSeeds = 1000;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    std::set<std::uint32_t> drawn;
    for (const auto& match : match_sampled(local, global, -1, 1000, {.seed = seed})) {
      drawn.insert(match.local_feature);
    }
    EXPECT_LE(drawn.size(), 5U);
    for (const std::uint32_t i : drawn) ++draws[i];
  }
  // 5 of 20, within five standard deviations.
  for (const int count : draws) EXPECT_NEAR(count, kSeeds / 4, 5.0 * std::sqrt(kSeeds * 0.1875));
}

TEST(MatchSampled, AgreesWithExhaustiveAtTheRateOfEquation18) {
  // A drawn feature that both maps hold finds the rotation that all features find. Draws are
  // without replacement, so p is a lower bound; three standard deviations of the binomial are
  // allowed.
  constexpr int kTrials = 200;
  int agreed = 0;
  for (std::uint64_t seed = 0; seed < kTrials; ++seed) {
    const Maps maps = overlapping_maps(50, 40.0, 0.0, seed);
    const DescriptorSet local = describe(maps.local, {});
    const DescriptorSet global = describe(maps.global, {});
    const auto exhaustive = match_exhaustive(local, global, 6, 1);
    const auto sampled = match_sampled(local, global, 6, 1, {.seed = seed});
    ASSERT_EQ(exhaustive.size(), 1U) << seed;
    const auto is_true = [&](const DescriptorMatch& match) {
      return match.local_feature == match.global_feature && match.local_feature < maps.shared;
    };
    EXPECT_TRUE(is_true(exhaustive[0])) << seed;
    if (!sampled.empty() && is_true(sampled[0])) ++agreed;
  }
  const double p = 0.95;
  EXPECT_GE(agreed, kTrials * p - 3.0 * std::sqrt(kTrials * p * (1.0 - p)));
}

TEST(SampleCount, FollowsEquation18) {
  EXPECT_EQ(sample_count({.success_probability = 0.95, .overlap = 0.5}, 300), 5U);
  EXPECT_EQ(sample_count({.success_probability = 0.99, .overlap = 0.3}, 300), 13U);
  EXPECT_EQ(sample_count({.success_probability = 0.95, .overlap = 1.0}, 300), 1U);
  EXPECT_EQ(sample_count({.success_probability = 0.01, .overlap = 0.9}, 300), 1U);
  EXPECT_EQ(sample_count({.success_probability = 0.95, .overlap = 0.01}, 40), 40U);
  EXPECT_EQ(sample_count({}, 0), 0U);
}

TEST(PairsOf, AreThoseThatVotedWithTheMatchItselfInFront) {
  const Maps maps = overlapping_maps(50, 30.0, 0.0, 9);
  const DescriptorSet local = describe(maps.local, {});
  const DescriptorSet global = describe(maps.global, {});
  const auto matches = match_exhaustive(local, global, 6, 1);
  ASSERT_EQ(matches.size(), 1U);
  const FeaturePairs pairs = pairs_of(matches[0], local[matches[0].local_feature],
                                      global[matches[0].global_feature], local.angle_bins());
  ASSERT_EQ(static_cast<int>(pairs.size()), matches[0].votes + 1);
  EXPECT_EQ(pairs[0], std::pair(matches[0].local_feature, matches[0].global_feature));
  const auto is_true = [](const auto& pair) { return pair.first == pair.second; };
  EXPECT_GE(std::ranges::count_if(pairs, is_true), 12);
}

TEST(SampledMatchParams, NameTheBrokenLimit) {
  EXPECT_FALSE(validate(SampledMatchParams{}));
  EXPECT_EQ(validate(SampledMatchParams{.success_probability = 1.0})->field, "success_probability");
  EXPECT_EQ(validate(SampledMatchParams{.overlap = 0.0})->field, "overlap");
}

}  // namespace
}  // namespace cornerfix

#include "core/src/matching/triangle_index.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tuple>

#include "support/feature_fields.hpp"
#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using testing::feature_field;
using ::testing::IsEmpty;
using testing::IsPoseNear;
using testing::random_features;
using testing::seen_again;
using testing::submap_of_field;
using testing::SubmapOfField;

constexpr std::size_t kSubmapFeatures = 50;

std::vector<Feature> moved(std::vector<Feature> features, const Pose2& T) {
  for (Feature& feature : features) feature = transformed(T, feature);
  return features;
}

TEST(TriangleIndex, FindsTheVeryPoseWithoutNoise) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    std::mt19937_64 random(seed);
    const auto map = feature_field(300, random);
    const auto submap = submap_of_field(map, kSubmapFeatures, 0.6, 0.0, random);
    const auto matches = TriangleIndex(map, {}).match(submap.features, {});
    ASSERT_EQ(matches.size(), 1U) << "seed " << seed;
    EXPECT_THAT(matches[0].T_map_submap, IsPoseNear(submap.T_map_submap, 0.02, 0.001)) << seed;
    EXPECT_GE(matches[0].inliers, 30) << seed;
  }
}

class TriangleRecall : public ::testing::TestWithParam<std::tuple<std::size_t, double>> {};

TEST_P(TriangleRecall, IsNearlyFullAndNothingIsWrong) {
  const auto [features, overlap] = GetParam();
  constexpr int kSubmaps = 100;
  std::mt19937_64 random(features);
  const auto map = feature_field(features, random);
  const TriangleIndex index(map, {});
  int found = 0;
  for (int i = 0; i < kSubmaps; ++i) {
    const auto submap = submap_of_field(map, kSubmapFeatures, overlap, 0.05, random);
    for (const TriangleMatch& match : index.match(submap.features, {})) {
      EXPECT_THAT(match.T_map_submap, IsPoseNear(submap.T_map_submap, 0.1, 0.01)) << i;
      ++found;
    }
  }
  EXPECT_GE(found, overlap < 0.5 ? 0.96 * kSubmaps : kSubmaps);
}

INSTANTIATE_TEST_SUITE_P(Sizes, TriangleRecall,
                         ::testing::Combine(::testing::Values(300U, 3'000U, 30'000U),
                                            ::testing::Values(0.5, 0.3)));

TEST(TriangleIndex, CostsLittleMoreInATownThanInAHouse) {
  const auto trials_among = [](std::size_t features) {
    std::mt19937_64 random(1);
    const auto map = feature_field(features, random);
    const TriangleIndex index(map, {});
    std::size_t trials = 0;
    for (int i = 0; i < 50; ++i) {
      const auto submap = submap_of_field(map, kSubmapFeatures, 0.5, 0.05, random);
      for (const TriangleMatch& match : index.match(submap.features, {})) trials += match.trials;
    }
    return trials;
  };
  EXPECT_LT(trials_among(30'000), 20 * trials_among(300));
}

TEST(TriangleIndex, NeverTakesAMirrorImage) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    std::mt19937_64 random(seed);
    const auto map = feature_field(300, random);
    auto submap = submap_of_field(map, kSubmapFeatures, 1.0, 0.0, random).features;
    for (Feature& feature : submap) feature.position.y() = -feature.position.y();
    EXPECT_THAT(TriangleIndex(map, {}).match(submap, {}), IsEmpty()) << "seed " << seed;
  }
}

TEST(TriangleIndex, FindsNoPlaceForAStrangeSubmap) {
  std::mt19937_64 random(1);
  const TriangleIndex index(feature_field(3'000, random), {});
  for (int i = 0; i < 50; ++i) {
    EXPECT_THAT(index.match(random_features(kSubmapFeatures, 60.0, random), {}), IsEmpty()) << i;
  }
}

TEST(TriangleIndex, NeedsFourFeatures) {
  std::mt19937_64 random(3);
  const auto map = random_features(40, 20.0, random);
  const TriangleIndex index(map, {});
  for (std::size_t count = 0; count < 4; ++count) {
    const std::vector<Feature> few(map.begin(), map.begin() + static_cast<std::ptrdiff_t>(count));
    EXPECT_THAT(index.match(few, {}), IsEmpty()) << count;
    EXPECT_THAT(TriangleIndex(few, {}).match(map, {}), IsEmpty()) << count;
  }
  EXPECT_THAT(TriangleIndex().match(map, {}), IsEmpty());
}

TEST(TriangleIndex, FindsNothingAmongFeaturesWithoutTriangles) {
  std::vector<Feature> in_a_line(50);
  for (std::size_t i = 0; i < in_a_line.size(); ++i)
    in_a_line[i].position = {1.3 * static_cast<double>(i * i), 0.0};
  const std::vector<Feature> in_a_point(50);
  for (const auto& features : {in_a_line, in_a_point}) {
    const TriangleIndex index(features, {});
    EXPECT_EQ(index.triangle_count(), 0U);
    EXPECT_THAT(index.match(features, {}), IsEmpty());
  }
}

TEST(TriangleIndex, MovesItsAnswerWithTheMap) {
  std::mt19937_64 random(5);
  const auto map = feature_field(300, random);
  const auto submap = submap_of_field(map, kSubmapFeatures, 0.5, 0.03, random);
  const Pose2 T_other_map{-4'000.0, 9'000.0, 2.7};
  const auto matches = TriangleIndex(moved(map, T_other_map), {}).match(submap.features, {});
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_THAT(matches[0].T_map_submap, IsPoseNear(T_other_map * submap.T_map_submap, 0.1, 0.01));
}

TEST(TriangleIndex, FindsASubmapFarFromItsOwnOrigin) {
  std::mt19937_64 random(5);
  const auto map = feature_field(300, random);
  const auto submap = submap_of_field(map, kSubmapFeatures, 0.5, 0.03, random);
  const Pose2 T_odom_submap{700.0, -300.0, 1.0};
  const auto matches = TriangleIndex(map, {}).match(moved(submap.features, T_odom_submap), {});
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_THAT(matches[0].T_map_submap * T_odom_submap, IsPoseNear(submap.T_map_submap, 0.1, 0.01));
}

TEST(TriangleIndex, TellsEachOfTwoLikePlacesOnce) {
  std::mt19937_64 random(6);
  const auto room = random_features(30, 40.0, random);
  const Pose2 T_map_other_room{50.0, 3.0, 1.2};
  auto map = room;
  const auto other_room = moved(room, T_map_other_room);
  map.insert(map.end(), other_room.begin(), other_room.end());
  const TriangleIndex index(map, {});
  const auto matches = index.match(seen_again(room, {}, 0.03, random), {.max_matches = 5});
  ASSERT_EQ(matches.size(), 2U);
  EXPECT_LE(matches[0].log_false_alarms, matches[1].log_false_alarms);
  const bool room_is_first = matches[0].T_map_submap.x < 25.0;
  EXPECT_THAT(matches[room_is_first ? 0 : 1].T_map_submap, IsPoseNear(Pose2{}, 0.1, 0.01));
  EXPECT_THAT(matches[room_is_first ? 1 : 0].T_map_submap, IsPoseNear(T_map_other_room, 0.1, 0.01));
}

TEST(TriangleIndex, AnswersAlikeForTheSameSeed) {
  std::mt19937_64 random(7);
  const auto map = feature_field(300, random);
  const TriangleIndex index(map, {});
  const auto submap = submap_of_field(map, kSubmapFeatures, 0.4, 0.05, random).features;
  const auto once = index.match(submap, {.seed = 3});
  const auto again = TriangleIndex(map, {}).match(submap, {.seed = 3});
  const auto other = index.match(submap, {.seed = 4});
  ASSERT_EQ(once.size(), 1U);
  ASSERT_EQ(again.size(), 1U);
  ASSERT_EQ(other.size(), 1U);
  EXPECT_EQ(once[0].T_map_submap, again[0].T_map_submap);
  EXPECT_EQ(once[0].trials, again[0].trials);
  EXPECT_NE(once[0].trials, other[0].trials);
}

TEST(TriangleIndex, StopsWhenTheTrialsAreSpent) {
  std::mt19937_64 random(8);
  const auto map = feature_field(3'000, random);
  const TriangleIndex index(map, {});
  for (int i = 0; i < 10; ++i) {
    const auto submap = submap_of_field(map, kSubmapFeatures, 0.5, 0.05, random).features;
    const auto matches = index.match(submap, {});
    ASSERT_EQ(matches.size(), 1U);
    const std::size_t needed = matches[0].trials;
    EXPECT_EQ(index.match(submap, {.max_trials = needed}).size(), 1U) << i;
    EXPECT_THAT(index.match(submap, {.max_trials = needed - 1}), IsEmpty()) << i;
  }
}

TEST(TriangleParams, NameTheBrokenLimit) {
  EXPECT_FALSE(validate(TriangleIndexParams{}));
  EXPECT_EQ(validate(TriangleIndexParams{.min_side_m = 0.0})->field, "min_side_m");
  EXPECT_EQ(validate(TriangleIndexParams{.neighbors = 2})->field, "neighbors");
  EXPECT_EQ(validate(TriangleIndexParams{.tolerance_m = -1.0})->field, "tolerance_m");
  EXPECT_FALSE(validate(TriangleMatchParams{}));
  EXPECT_EQ(validate(TriangleMatchParams{.overlap = 1.0})->field, "overlap");
  EXPECT_EQ(validate(TriangleMatchParams{.max_log_false_alarms = 0.0})->field,
            "max_log_false_alarms");
  EXPECT_EQ(validate(TriangleMatchParams{.max_trials = 0})->field, "max_trials");
  EXPECT_EQ(validate(TriangleMatchParams{.max_matches = 0})->field, "max_matches");
}

}  // namespace
}  // namespace cornerfix

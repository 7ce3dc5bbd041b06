#include "core/src/matching/pose_estimator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using ::testing::ElementsAre;
using testing::IsPoseNear;

/// `right` correspondences of a pose with noise, then `wrong` ones at random, in 20 m by 20 m.
std::vector<Correspondence> correspondences_of(const Pose2& T_map_submap, std::size_t right,
                                               std::size_t wrong, double noise_m,
                                               std::mt19937_64& random) {
  std::uniform_real_distribution<double> coordinate(-10.0, 10.0);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<Correspondence> result;
  for (std::size_t i = 0; i < right + wrong; ++i) {
    const Point2 p(coordinate(random), coordinate(random));
    const Point2 q = i < right ? T_map_submap * p
                               : T_map_submap * Point2(coordinate(random), coordinate(random));
    result.push_back({p, q + noise_m * Point2(noise(random), noise(random))});
  }
  return result;
}

Pose2 pose_in_square(std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  return {50.0 * share(random), 50.0 * share(random), 3.14159 * share(random)};
}

TEST(FitRigid, RecoversAKnownPose) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    std::mt19937_64 random(seed);
    const Pose2 truth = pose_in_square(random);
    const auto fitted = fit_rigid(correspondences_of(truth, 2 + seed % 10, 0, 0.0, random));
    ASSERT_TRUE(fitted) << seed;
    EXPECT_THAT(*fitted, IsPoseNear(truth, 1e-9, 1e-9)) << seed;
  }
}

TEST(FitRigid, HasNoAnswerWithoutADirection) {
  EXPECT_FALSE(fit_rigid({}));
  EXPECT_FALSE(fit_rigid(std::vector<Correspondence>{{{1, 2}, {3, 4}}}));
  EXPECT_FALSE(fit_rigid(std::vector<Correspondence>(5, {{1.1, 2.3}, {3.7, 4.9}})));
  // A square and its mirror image: every rotation fits alike.
  EXPECT_FALSE(fit_rigid(std::vector<Correspondence>{
      {{1, 1}, {1, -1}}, {{-1, 1}, {-1, -1}}, {{-1, -1}, {-1, 1}}, {{1, -1}, {1, 1}}}));
}

TEST(EstimatePose, RecoversAKnownPoseAmongWrongCorrespondences) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    std::mt19937_64 random(seed);
    const Pose2 truth = pose_in_square(random);
    const auto correspondences = correspondences_of(truth, 12, 12, 0.05, random);
    const auto estimate = estimate_pose(correspondences, {.seed = seed});
    ASSERT_TRUE(estimate) << seed;
    EXPECT_THAT(estimate->T_map_submap, IsPoseNear(truth, 0.12, 0.015)) << seed;
    EXPECT_GE(estimate->inliers.size(), 12U) << seed;
    EXPECT_LT(estimate->rms_residual_m, 0.2) << seed;
  }
}

TEST(EstimatePose, NamesTheInliersInAscendingOrder) {
  std::mt19937_64 random(3);
  auto correspondences = correspondences_of({5, 5, 1}, 6, 0, 0.0, random);
  std::ranges::reverse(correspondences);
  correspondences.insert(correspondences.begin() + 2, {{1, 1}, {90, 90}});
  const auto estimate = estimate_pose(correspondences, {});
  ASSERT_TRUE(estimate);
  EXPECT_THAT(estimate->inliers, ElementsAre(0, 1, 3, 4, 5, 6));
  EXPECT_LT(estimate->rms_residual_m, 1e-9);
}

TEST(EstimatePose, FitsAllInliersNotOnlyTheSampledPair) {
  std::mt19937_64 random(11);
  const Pose2 truth{1, 2, 0.5};
  const auto correspondences = correspondences_of(truth, 200, 0, 0.08, random);
  const auto estimate = estimate_pose(correspondences, {});
  ASSERT_TRUE(estimate);
  EXPECT_THAT(estimate->T_map_submap, IsPoseNear(truth, 0.02, 0.003));
}

TEST(EstimatePose, MovesWithTheMap) {
  std::mt19937_64 random(4);
  auto correspondences = correspondences_of({5, 5, 1}, 8, 8, 0.03, random);
  const auto here = estimate_pose(correspondences, {});
  const Pose2 T_other_map{100, -40, 2.5};
  for (Correspondence& c : correspondences) c.point_map = T_other_map * c.point_map;
  const auto there = estimate_pose(correspondences, {});
  ASSERT_TRUE(here && there);
  EXPECT_THAT(there->T_map_submap, IsPoseNear(T_other_map * here->T_map_submap, 1e-9, 1e-9));
  EXPECT_EQ(there->inliers, here->inliers);
}

TEST(EstimatePose, FindsTheSameInWhateverOrderTheCorrespondencesCome) {
  std::mt19937_64 random(5);
  auto correspondences = correspondences_of({5, 5, 1}, 10, 5, 0.03, random);
  const auto plain = estimate_pose(correspondences, {});
  std::shuffle(correspondences.begin(), correspondences.end(), random);
  const auto shuffled = estimate_pose(correspondences, {});
  ASSERT_TRUE(plain && shuffled);
  EXPECT_EQ(shuffled->inliers.size(), plain->inliers.size());
  EXPECT_THAT(shuffled->T_map_submap, IsPoseNear(plain->T_map_submap, 1e-9, 1e-9));
}

TEST(EstimatePose, AsksForEnoughInliers) {
  std::mt19937_64 random(6);
  const auto correspondences = correspondences_of({5, 5, 1}, 5, 0, 0.0, random);
  EXPECT_TRUE(estimate_pose(correspondences, {.min_inliers = 5}));
  EXPECT_FALSE(estimate_pose(correspondences, {.min_inliers = 6}));
  EXPECT_FALSE(estimate_pose({}, {}));
}

TEST(EstimatePose, CountsARepeatedCorrespondenceOnce) {
  const Correspondence a{{0, 0}, {5, 5}};
  const Correspondence b{{3, 0}, {8, 5}};
  EXPECT_FALSE(estimate_pose(std::vector<Correspondence>{a, a, a, a, b, b, b, b}, {}));
  EXPECT_FALSE(estimate_pose(std::vector<Correspondence>(10, a), {}));
}

TEST(EstimatePose, CountsASubmapPointOnceAndTakesTheNearestOffer) {
  std::mt19937_64 random(7);
  auto correspondences = correspondences_of({5, 5, 1}, 6, 0, 0.0, random);
  correspondences.push_back(correspondences[2]);
  correspondences[2].point_map += Point2(0.2, 0.0);
  const auto estimate = estimate_pose(correspondences, {});
  ASSERT_TRUE(estimate);
  EXPECT_THAT(estimate->inliers, ElementsAre(0, 1, 3, 4, 5, 6));
}

TEST(EstimatePose, RefusesAMirrorImage) {
  std::mt19937_64 random(8);
  auto correspondences = correspondences_of({}, 12, 0, 0.0, random);
  for (Correspondence& c : correspondences) c.point_map.x() = -c.point_map.x();
  EXPECT_FALSE(estimate_pose(correspondences, {.min_inliers = 6}));
}

TEST(EstimatePose, RefusesASubmapThatCollapsesToAPoint) {
  std::mt19937_64 random(9);
  auto correspondences = correspondences_of({}, 12, 0, 0.0, random);
  for (Correspondence& c : correspondences) c.point_map = {1, 1};
  EXPECT_FALSE(estimate_pose(correspondences, {}));
}

TEST(EstimatePose, GivesTheSameForTheSameSeed) {
  std::mt19937_64 random(10);
  const auto correspondences = correspondences_of({5, 5, 1}, 10, 40, 0.1, random);
  const auto first = estimate_pose(correspondences, {.seed = 3});
  const auto second = estimate_pose(correspondences, {.seed = 3});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->T_map_submap, second->T_map_submap);
}

TEST(PoseEstimatorParams, NameTheBrokenLimit) {
  EXPECT_FALSE(validate(PoseEstimatorParams{}));
  EXPECT_EQ(validate(PoseEstimatorParams{.inlier_distance_m = 0.0})->field, "inlier_distance_m");
  EXPECT_EQ(validate(PoseEstimatorParams{.min_inliers = 1})->field, "min_inliers");
  EXPECT_EQ(validate(PoseEstimatorParams{.max_iterations = 0})->field, "max_iterations");
  EXPECT_EQ(validate(PoseEstimatorParams{.max_iterations = 10001})->field, "max_iterations");
}

}  // namespace
}  // namespace cornerfix

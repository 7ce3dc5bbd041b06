#include "core/src/search/global_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/mapped_floor.hpp"
#include "support/matchers.hpp"
#include "unit/core/search/seen_offices.hpp"

namespace cornerfix {
namespace {

using namespace search_tests;
using testing::IsPoseNear;

const std::vector<LocalizationMapPtr>& office_maps() {
  static const std::vector<LocalizationMapPtr> maps{office_map()};
  return maps;
}

class GlobalSearchMethods : public ::testing::TestWithParam<Method> {};

TEST_P(GlobalSearchMethods, FindTheTruePoseAndAcceptIt) {
  LocalizerParams params;
  params.method = GetParam();
  GlobalSearch search(params);
  search.propose(office_maps(), office_view(), 1);
  search.judge(office_maps(), office_view());
  search.search(office_maps(), office_view());
  ASSERT_FALSE(search.candidates().empty());
  EXPECT_THAT(search.candidates().best().T_map_base_link, IsPoseNear(kTruth, 0.05, 0.02));
  EXPECT_TRUE(search.acceptable());
  EXPECT_TRUE(search.searched()) << "no pose is accepted before all poses were compared";
  EXPECT_FALSE(search.mirror_image_fits_better(office_maps(), office_view()));
}

INSTANTIATE_TEST_SUITE_P(All, GlobalSearchMethods,
                         ::testing::Values(Method::kIndexed, Method::kRma, Method::kNma),
                         [](const auto& test) { return std::string(to_string(test.param)); });

TEST(GlobalSearch, KeepsBothOfTwoAliasedPoses) {
  const std::vector<LocalizationMapPtr> maps{
      testing::mapped_floor(testing::equal_rooms(), {{3.0, 2.5}, {23.0, 2.5}}, {27.0, 5.0})};
  const Pose2 path[] = {{2.0, 1.5, 0.0}, {3.0, 2.5, 0.4}};
  const View view = testing::view_along(testing::equal_rooms(), path);
  GlobalSearch search(LocalizerParams{});
  search.propose(maps, view, 1);
  search.judge(maps, view);
  search.search(maps, view);
  std::vector<Pose2> poses;
  for (const Candidate& one : search.candidates().all()) poses.push_back(one.T_map_base_link);
  EXPECT_THAT(poses, ::testing::Contains(IsPoseNear(path[1], 0.1, 0.03)));
  EXPECT_THAT(poses, ::testing::Contains(IsPoseNear(Pose2{23.0, 2.5, 0.4}, 0.1, 0.03)));
  EXPECT_FALSE(search.acceptable());
}

TEST(GlobalSearch, ComparesPosesOfTheRegionOnly) {
  const std::vector<LocalizationMapPtr> maps{
      testing::mapped_floor(testing::equal_rooms(), {{3.0, 2.5}, {23.0, 2.5}}, {27.0, 5.0})};
  const Pose2 path[] = {{2.0, 1.5, 0.0}, {3.0, 2.5, 0.4}};
  const View view = testing::view_along(testing::equal_rooms(), path);
  GlobalSearch search(LocalizerParams{});
  search.restrict_to({.center = {22.0, 1.5}, .radius_m = 2.0}, inverse(path[0]) * path[1]);
  search.propose(maps, view, 1);
  search.judge(maps, view);
  search.search(maps, view);
  ASSERT_FALSE(search.candidates().empty());
  for (const Candidate& one : search.candidates().all()) EXPECT_GT(one.T_map_base_link.x, 20.0);
  EXPECT_TRUE(search.acceptable());
  search.lift_restriction();
  const Candidate best = search.candidates().best();
  search.review(maps, view, best, true);
  EXPECT_FALSE(search.acceptable()) << "the other room is a rival again";
}

TEST(GlobalSearch, FindsTheMirrorImageOfAScanThatWasTakenUpsideDown) {
  const View upside_down = mirrored(office_view());
  GlobalSearch search(LocalizerParams{});
  const Candidate wrong{.map = 0, .T_map_base_link = {7.5, 1.0, 0.3}};
  search.review(office_maps(), upside_down, wrong, true);
  ASSERT_FALSE(search.candidates().empty());
  EXPECT_TRUE(search.mirror_image_fits_better(office_maps(), upside_down));
}

TEST(GlobalSearch, ARoomThatDiffersFromItsMirrorImageInOneObjectIsSymmetric) {
  testing::SceneBuilder scene;
  scene.room({0.0, 0.0}, {8.0, 4.8}).box({5.6, 3.2}, {0.7, 0.7});
  const std::vector<LocalizationMapPtr> maps{testing::make_map(scene, {3.2, 2.4})};
  const Pose2 path[] = {{2.7, 2.4, 0.0}, {3.2, 2.4, 0.1}};
  const View view = testing::view_along(scene, path);
  GlobalSearch search(LocalizerParams{});
  search.review(maps, view, {.map = 0, .T_map_base_link = path[1]}, true);
  ASSERT_FALSE(search.candidates().empty());
  EXPECT_THAT(search.candidates().best().T_map_base_link, IsPoseNear(path[1], 0.05, 0.02));
  EXPECT_TRUE(search.mirror_image_fits_better(maps, view));
}

TEST(GlobalSearch, ReviewComparesTheTrackedPoseWithAllOthers) {
  GlobalSearch search(LocalizerParams{});
  const Candidate tracked{.map = 0, .T_map_base_link = kTruth};
  EXPECT_FALSE(search.review(office_maps(), office_view(), tracked, false));
  EXPECT_FALSE(search.searched());
  EXPECT_TRUE(search.review(office_maps(), office_view(), tracked, true));
  EXPECT_TRUE(search.searched());
  EXPECT_TRUE(search.acceptable());
  EXPECT_GT(search.terms().probability_correct, 0.995);
}

TEST(GlobalSearch, ForgetsAllWhenReset) {
  GlobalSearch search(LocalizerParams{});
  search.propose(office_maps(), office_view(), 1);
  search.judge(office_maps(), office_view());
  search.search(office_maps(), office_view());
  ASSERT_FALSE(search.candidates().empty());
  search.reset();
  EXPECT_TRUE(search.candidates().empty());
  EXPECT_FALSE(search.searched());
}

}  // namespace
}  // namespace cornerfix

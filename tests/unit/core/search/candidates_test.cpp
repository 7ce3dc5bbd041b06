#include "core/src/search/candidates.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/src/search/same_place.hpp"
#include "support/mapped_floor.hpp"
#include "support/matchers.hpp"
#include "unit/core/search/seen_offices.hpp"

namespace cornerfix {
namespace {

using namespace search_tests;
using testing::IsPoseNear;

constexpr double kDepth = 0.75;

/// The poses, considered one after the other, in a map as large as the offices.
Candidates considered(const std::vector<Pose2>& poses) {
  Candidates candidates;
  candidates.set_free_area(office_map()->free_area_m2());
  for (const Pose2& pose : poses)
    candidates.consider(*office_map(), office_view(), {.map = 0, .T_map_base_link = pose});
  return candidates;
}

TEST(Candidates, AreRefined) {
  const Candidates candidates = considered({kTruth * Pose2{0.2, -0.15, 0.08}});
  ASSERT_EQ(candidates.all().size(), 1U);
  EXPECT_THAT(candidates.best().T_map_base_link, IsPoseNear(kTruth, 0.05, 0.02));
}

TEST(Candidates, HoldTheBetterOfTwoAtOnePlace) {
  const Candidates candidates =
      considered({kTruth * Pose2{0.1, 0.0, 0.05}, kTruth * Pose2{-0.1, 0.1, -0.05}});
  EXPECT_EQ(candidates.all().size(), 1U);
}

TEST(Candidates, ComeBestFirst) {
  // The second room is wrong, but not so wrong that it is left out at once.
  const Candidates candidates = considered({{7.5, 4.5, 1.4}, kTruth});
  ASSERT_FALSE(candidates.empty());
  EXPECT_THAT(candidates.best().T_map_base_link, IsPoseNear(kTruth, 0.05, 0.02));
  for (const Candidate& other : candidates.all().subspan(1))
    EXPECT_LE(other.score.fit, candidates.best().score.fit);
}

TEST(Candidates, TheTruePoseIsAcceptedWithoutRivals) {
  const Candidates candidates = considered({kTruth});
  const AcceptanceTerms terms = candidates.terms(kDepth);
  EXPECT_GT(terms.probability_correct, 0.995);
  EXPECT_TRUE(candidates.acceptable(kDepth));
  EXPECT_EQ(candidates.missing_without_rivals(), Reason::kNone);
}

TEST(Candidates, AShallowSearchLeavesNoMargin) {
  const Candidates candidates = considered({kTruth});
  EXPECT_FALSE(candidates.acceptable(0.0));
}

TEST(Candidates, AnAliasedPoseForbidsAcceptance) {
  const LocalizationMapPtr map =
      testing::mapped_floor(testing::equal_rooms(), {{3.0, 2.5}, {23.0, 2.5}}, {27.0, 5.0});
  const Pose2 path[] = {{2.0, 1.5, 0.0}, {3.0, 2.5, 0.4}};
  const View view = testing::view_along(testing::equal_rooms(), path);
  Candidates candidates;
  candidates.set_free_area(map->free_area_m2());
  candidates.consider(*map, view, {.map = 0, .T_map_base_link = path[1]});
  candidates.consider(*map, view, {.map = 0, .T_map_base_link = {23.0, 2.5, 0.4}});
  ASSERT_EQ(candidates.all().size(), 2U);
  EXPECT_FALSE(candidates.acceptable(kDepth));
  EXPECT_LT(candidates.terms(kDepth).probability_correct, 0.5);
}

TEST(Candidates, MoveWithTheRobot) {
  Candidates candidates = considered({kTruth});
  const Pose2 before = candidates.best().T_map_base_link;
  const Pose2 motion{0.5, 0.1, 0.3};
  candidates.move_along(motion);
  EXPECT_THAT(candidates.best().T_map_base_link, IsPoseNear(before * motion, 1e-9, 1e-9));
  EXPECT_TRUE(candidates.knows(0, before * motion));
  EXPECT_FALSE(candidates.knows(1, before * motion));
}

TEST(Candidates, AreJudgedAgainByWhatIsSeenLater) {
  Candidates candidates = considered({kTruth});
  const int hits = candidates.best().score.ends;
  const Pose2 first_scan[] = {kTruth};
  const LocalizationMapPtr maps[] = {office_map()};
  candidates.judge_again(maps, testing::view_along(testing::offices(), first_scan));
  ASSERT_FALSE(candidates.empty());
  EXPECT_LT(candidates.best().score.ends, hits);
  candidates.clear();
  EXPECT_TRUE(candidates.empty());
}

}  // namespace
}  // namespace cornerfix

#include "core/src/search/corner_hypotheses.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include <cornerfix/corners.hpp>

#include "core/src/scan/evidence_grid.hpp"
#include "core/src/search/map_index.hpp"
#include "support/floor_plans.hpp"
#include "support/map_maker.hpp"
#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using ::testing::IsEmpty;
using testing::IsPoseNear;
using ::testing::SizeIs;

/// What a scan in random_room(seed) shows, in base_link.
struct Seen {
  Pose2 T_map_base_link;
  std::vector<Feature> corners;
  std::vector<Point2> ends;
};

Seen seen_in_room(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> position(-0.8, 0.8),
      yaw(-std::numbers::pi, std::numbers::pi);
  const Pose2 pose{position(random), position(random), yaw(random)};
  const LaserScan scan = testing::simulate_scan(testing::random_room(seed),
                                                {.beams = 720, .noise_m = 0.01}, pose, random);
  EvidenceGrid grid;
  grid.add(scan, {});
  return {pose, extract_corners(scan, CornerExtractor::kLineIntersection), grid.collect().ends};
}

LocalizationMapPtr map_of_room(std::uint64_t seed) {
  return testing::make_map(testing::random_room(seed), {0.0, 0.0});
}

std::vector<Hypothesis> hypotheses(const LocalizationMap& map, const Seen& seen,
                                   const CornerHypothesisParams& params = {}) {
  return hypotheses_from_corners(map, seen.corners, seen.ends, params);
}

TEST(CornerHypotheses, HoldThePlaceOfTheRobotAndRankItFirst) {
  int first = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Seen seen = seen_in_room(seed);
    const std::vector<Hypothesis> found = hypotheses(*map_of_room(seed), seen);
    const auto is_true = [&](const Hypothesis& one) {
      return distance(one.T_map_base_link, seen.T_map_base_link) < 0.3 &&
             angle_between(one.T_map_base_link, seen.T_map_base_link) < 0.1;
    };
    EXPECT_TRUE(std::ranges::any_of(found, is_true)) << "seed " << seed;
    first += !found.empty() && is_true(found.front()) ? 1 : 0;
  }
  EXPECT_GE(first, 18);
}

TEST(CornerHypotheses, AreFoundFromOneCornerAlone) {
  const Seen seen = seen_in_room(3);
  const LocalizationMapPtr map = map_of_room(3);
  int found = 0;
  for (const Feature& corner : seen.corners) {
    const auto places = hypotheses_from_corners(*map, std::span(&corner, 1), seen.ends, {});
    found += std::ranges::any_of(places,
                                 [&](const Hypothesis& one) {
                                   return distance(one.T_map_base_link, seen.T_map_base_link) < 0.3;
                                 })
                 ? 1
                 : 0;
  }
  EXPECT_GE(found, 3) << "of " << seen.corners.size() << " corners";
}

TEST(CornerHypotheses, AreFoundFromTrianglesAlone) {
  const LocalizationMapPtr map = testing::make_map(testing::offices(), {1.0, 1.0});
  const Pose2 T_map_base_link{1.0, 1.0, 0.7};
  Seen seen{T_map_base_link, {}, {}};
  for (const Feature& mapped : map->features()) {
    Feature corner = transformed(inverse(T_map_base_link), mapped);
    if (corner.position.norm() > 8.0) continue;
    seen.ends.push_back(corner.position);
    corner.turn_angle = 3.0;  // No pair is of one kind.
    seen.corners.push_back(corner);
  }
  ASSERT_GE(seen.corners.size(), 8U);
  EXPECT_THAT(hypotheses(*map, seen, {.max_triangles = 0}), IsEmpty());
  for (const std::size_t pairs : {std::size_t{6'000}, std::size_t{0}}) {  // Of none, and none left.
    const auto found = hypotheses(*map, seen, {.max_pairs = pairs});
    ASSERT_FALSE(found.empty());
    EXPECT_THAT(found.front().T_map_base_link, IsPoseNear(T_map_base_link, 0.1, 0.02));
  }
}

TEST(CornerHypotheses, MoveWithTheMap) {
  const Seen seen = seen_in_room(4);
  Seen turned = seen;
  const Pose2 T_turned_base_link{0.4, -0.3, 1.1};
  for (Feature& corner : turned.corners) corner = transformed(T_turned_base_link, corner);
  for (Point2& end : turned.ends) end = T_turned_base_link * end;
  const LocalizationMapPtr map = map_of_room(4);
  const auto here = hypotheses(*map, seen);
  const auto there = hypotheses(*map, turned);
  ASSERT_FALSE(here.empty());
  ASSERT_FALSE(there.empty());
  EXPECT_THAT(there.front().T_map_base_link * T_turned_base_link,
              IsPoseNear(here.front().T_map_base_link, 1e-6, 1e-6));
}

TEST(CornerHypotheses, AreDistinctPlacesInFreeSpaceBestFirst) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const LocalizationMapPtr map = map_of_room(seed);
    const auto found =
        hypotheses(*map, seen_in_room(seed + 50), {.max_places = 20, .min_mean_weight = -0.6});
    ASSERT_GE(found.size(), 2U) << "seed " << seed;
    EXPECT_TRUE(std::ranges::is_sorted(found, std::greater{}, &Hypothesis::mean_weight));
    const Pose2& T_grid_map = map->index().classes.T_grid_map();
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Point2 cell =
          T_grid_map * found[i].T_map_base_link.translation() / map->index().classes.resolution();
      const std::size_t pass = map->index().classes.pass_class(
          static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y())));
      EXPECT_TRUE(pass == static_cast<std::size_t>(PassClass::kFree) ||
                  pass == static_cast<std::size_t>(PassClass::kNearWall));
      for (std::size_t j = 0; j < i; ++j) {
        EXPECT_TRUE(distance(found[i].T_map_base_link, found[j].T_map_base_link) >= 1.0 ||
                    angle_between(found[i].T_map_base_link, found[j].T_map_base_link) >= 0.26);
      }
    }
  }
}

TEST(CornerHypotheses, AreNoMoreThanAskedFor) {
  const LocalizationMapPtr map = map_of_room(6);
  const Seen seen = seen_in_room(56);
  EXPECT_THAT(hypotheses(*map, seen, {.max_places = 1, .min_mean_weight = -1.0}), SizeIs(1));
  EXPECT_THAT(hypotheses(*map, seen, {.max_pairs = 0, .max_triangles = 0}), IsEmpty());
}

TEST(CornerHypotheses, AreTheSameForTheSameSeed) {
  const LocalizationMapPtr map = map_of_room(7);
  const Seen seen = seen_in_room(7);
  const auto once = hypotheses(*map, seen, {.seed = 5});
  const auto again = hypotheses(*map, seen, {.seed = 5});
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i)
    EXPECT_EQ(once[i].T_map_base_link, again[i].T_map_base_link);
}

TEST(CornerHypotheses, NeedCornersAndEnds) {
  const LocalizationMapPtr map = map_of_room(8);
  const Seen seen = seen_in_room(8);
  EXPECT_THAT(hypotheses_from_corners(*map, {}, seen.ends, {}), IsEmpty());
  EXPECT_THAT(hypotheses_from_corners(*map, seen.corners, {}, {}), IsEmpty());
  const LocalizationMap nothing("empty", 1, testing::map_content({}));
  EXPECT_THAT(hypotheses(nothing, seen), IsEmpty());
}

}  // namespace
}  // namespace cornerfix

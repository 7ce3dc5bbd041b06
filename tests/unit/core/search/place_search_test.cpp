#include "core/src/search/place_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include "core/src/search/work_budget.hpp"
#include "support/drawn_grid.hpp"
#include "support/matchers.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;
using testing::SceneBuilder;

using std::numbers::pi;
const std::vector<Point2> kHere{Point2::Zero()};  ///< The way of a robot that has not moved.

ClassField class_field_of(const OccupancyGrid& grid) { return {grid, DistanceField(grid)}; }

ClassField room_classes(double resolution = 0.05, double yaw = 0.0) {
  const Pose2 T_map_grid = Pose2{5.0, 5.0, yaw} * Pose2{-7.025, -7.025, 0.0};
  return class_field_of(testing::drawn_grid(testing::figure7_room(), {6.0, 5.0}, T_map_grid,
                                            {14.0, 14.0}, resolution));
}

std::vector<Point2> ends_at(const SceneBuilder& scene, const Pose2& T_map_laser,
                            std::uint64_t seed = 1, double range_max_m = 30.0) {
  std::mt19937_64 random(seed);
  EvidenceGrid grid;
  grid.add(
      testing::simulate_scan(scene, {.beams = 720, .range_max_m = range_max_m, .noise_m = 0.01},
                             T_map_laser, random),
      {});
  return grid.collect().ends;
}

Pose2 pose_in_room(std::mt19937_64& random) {
  std::uniform_real_distribution<double> x(4.0, 8.0), y(3.5, 7.0), yaw(-pi, pi);
  return {x(random), y(random), yaw(random)};
}

/// Weights of the classes that the ends fall in, averaged: what the search bounds from above.
double mean_weight(const ClassField& classes, std::span<const Point2> ends, const Pose2& T) {
  const Pose2 T_grid_base_link = classes.T_grid_map() * T;
  double sum = 0.0;
  for (const Point2& end : ends) {
    const Point2 cell = (T_grid_base_link * end) / classes.resolution();
    sum += static_cast<double>(kSearchWeights.ends[classes.end_class(
        static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y())))]);
  }
  return sum / static_cast<double>(ends.size());
}

std::size_t count_near(const std::vector<Place>& places, const Pose2& pose, double metres,
                       double radians) {
  return static_cast<std::size_t>(std::ranges::count_if(places, [&](const Place& place) {
    return distance(place.T_map_base_link, pose) <= metres &&
           angle_between(place.T_map_base_link, pose) <= radians;
  }));
}

TEST(PlaceSearch, FindsTheTruePlaceInAllOfTheMap) {
  for (const double resolution : {0.02, 0.05, 0.11, 0.3}) {
    const PlaceSearch search(room_classes(resolution));
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      std::mt19937_64 random(seed);
      const Pose2 truth = pose_in_room(random);
      const std::vector<Place> places =
          search.find(ends_at(testing::figure7_room(), truth, seed), kHere, {});
      ASSERT_FALSE(places.empty()) << "seed " << seed << ", " << resolution << " m/cell";
      EXPECT_THAT(places.front().T_map_base_link,
                  IsPoseNear(truth, std::max(0.35, 1.5 * resolution), 0.07))
          << "seed " << seed << ", " << resolution << " m/cell";
    }
  }
}

TEST(PlaceSearch, FindsTheTruePlaceInATurnedGrid) {
  for (const double yaw : {3.14, -0.7}) {
    const PlaceSearch search(room_classes(0.05, yaw));
    const Pose2 truth{6.5, 5.5, 2.0};
    const std::vector<Place> places =
        search.find(ends_at(testing::figure7_room(), truth), kHere, {});
    ASSERT_FALSE(places.empty());
    EXPECT_THAT(places.front().T_map_base_link, IsPoseNear(truth, 0.35, 0.07)) << "yaw " << yaw;
  }
}

/// The bound is a bound: no pose of a lattice, laid anywhere, scores more than the best place.
TEST(PlaceSearch, NoPoseOfALatticeIsBetterThanTheBestPlace) {
  const SceneBuilder scene =
      SceneBuilder().room({0, 0}, {5.0, 4.0}).box({1.2, 2.8}, {0.8, 0.5}, 0.4).wall({3, 0}, {3, 1});
  const ClassField classes =
      class_field_of(testing::drawn_grid(scene, {2.0, 1.0}, {-0.5, -0.5, 0.0}, {6.0, 5.0}, 0.05));
  const PlaceSearch search(classes);
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> x(1.5, 4.5), y(0.5, 2.0), yaw(-pi, pi), share(0, 1);
    const std::vector<Point2> ends = ends_at(scene, {x(random), y(random), yaw(random)}, seed);
    const PlaceSearchParams params{.max_points = 1000, .min_mean_weight = -1.0};
    const std::vector<Place> places = search.find(ends, {}, params);
    ASSERT_FALSE(places.empty());
    const Point2 offset(0.2 * share(random), 0.2 * share(random));
    double best = -10.0;
    for (int heading = 0; heading < 180; heading += 6) {
      for (int column = 0; column < 25; ++column) {
        for (int row = 0; row < 20; ++row) {
          const Pose2 pose{0.2 * column + offset.x(), 0.2 * row + offset.y(),
                           wrap_angle(heading * pi / 90.0)};
          best = std::max(best, mean_weight(classes, ends, pose));
        }
      }
    }
    constexpr double kQuantisation = 0.05;  // of the weights, in the search
    EXPECT_GE(places.front().mean_weight, best - kQuantisation) << "seed " << seed;
  }
}

TEST(PlaceSearch, PlacesComeBestFirst) {
  const PlaceSearch search(room_classes());
  const std::vector<Place> places =
      search.find(ends_at(testing::figure7_room(), {6.0, 5.0, 0.4}), kHere,
                  {.min_mean_weight = -1.0, .max_mean_gap = 2.0});
  ASSERT_GT(places.size(), 2U);
  EXPECT_TRUE(std::ranges::is_sorted(places, std::greater{}, &Place::mean_weight));
}

TEST(PlaceSearch, PlacesAreDistinct) {
  const PlaceSearch search(room_classes());
  for (const PlaceSearchParams& params :
       {PlaceSearchParams{.min_mean_weight = -1.0, .max_mean_gap = 2.0},
        PlaceSearchParams{.min_mean_weight = -1.0,
        .max_mean_gap = 2.0,
        .max_places = 5,
        .distinct_distance_m = 2.5},
        PlaceSearchParams{
            .min_mean_weight = -1.0, .max_mean_gap = 2.0, .distinct_angle_rad = 1.0}}) {
    const std::vector<Place> places =
        search.find(ends_at(testing::figure7_room(), {6.0, 5.0, 0.4}), kHere, params);
    ASSERT_GT(places.size(), 2U);
    for (const Place& place : places) {
      EXPECT_EQ(count_near(places, place.T_map_base_link, params.distinct_distance_m - 1e-6,
                           params.distinct_angle_rad - 1e-6),
                1U);
    }
  }
}

TEST(PlaceSearch, ASymmetricRoomHasTwoPlaces) {
  const SceneBuilder scene = SceneBuilder().room({0, 0}, {8.0, 5.0});
  const PlaceSearch search(
      class_field_of(testing::drawn_grid(scene, {1, 1}, {-1.0, -1.0, 0.0}, {10.0, 7.0}, 0.05)));
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> x(1.0, 3.0), y(0.8, 4.2), yaw(-pi, pi);
    const Pose2 truth{x(random), y(random), yaw(random)};
    const Pose2 twin{8.0 - truth.x, 5.0 - truth.y, wrap_angle(truth.yaw + pi)};
    const std::vector<Place> places = search.find(ends_at(scene, truth, seed), kHere, {});
    ASSERT_GE(places.size(), 2U) << "seed " << seed;
    const std::vector<Place> best(places.begin(), places.begin() + 2);
    EXPECT_EQ(count_near(best, truth, 0.35, 0.07), 1U) << "seed " << seed;
    EXPECT_EQ(count_near(best, twin, 0.35, 0.07), 1U) << "seed " << seed;
  }
}

TEST(PlaceSearch, AWayThroughUnknownSpaceCostsWeight) {
  const PlaceSearch search(room_classes());
  const Pose2 truth{6.0, 5.0, 0.4};
  const std::vector<Point2> ends = ends_at(testing::figure7_room(), truth);
  const auto best_with_way_from = [&](const Point2& start_map) {
    const std::vector<Point2> way{inverse(truth) * start_map, Point2::Zero()};
    const std::vector<Place> places = search.find(ends, way, {});
    return places.empty() ? -1.0 : places.front().mean_weight;
  };
  EXPECT_LT(best_with_way_from({6.0, 11.5}), best_with_way_from({6.0, 6.0}));
}

TEST(PlaceSearch, LeavesOutPlacesBelowTheThreshold) {
  const PlaceSearch search(room_classes());
  const std::vector<Point2> ends = ends_at(testing::figure7_room(), {6.0, 5.0, 0.4});
  const std::vector<Place> all =
      search.find(ends, kHere, {.min_mean_weight = -1.0, .max_mean_gap = 2.0});
  ASSERT_GT(all.size(), 1U);
  const double threshold = 0.5 * (all[0].mean_weight + all[1].mean_weight);
  const std::vector<Place> best = search.find(ends, kHere, {.min_mean_weight = threshold});
  ASSERT_EQ(best.size(), 1U);
  EXPECT_EQ(best[0].T_map_base_link, all[0].T_map_base_link);
  EXPECT_TRUE(search.find(ends, kHere, {.min_mean_weight = all[0].mean_weight + 0.1}).empty());
}

TEST(PlaceSearch, SaysOfAFoundPlaceWhatItSaidWhenItFoundIt) {
  const PlaceSearch search(room_classes());
  const std::vector<Point2> ends = ends_at(testing::figure7_room(), {6.0, 5.0, 0.4});
  const std::vector<Place> places =
      search.find(ends, kHere, {.min_mean_weight = -1.0, .max_mean_gap = 2.0});
  ASSERT_GT(places.size(), 2U);
  for (const Place& place : places)
    EXPECT_NEAR(search.mean_weight(ends, kHere, 100, place.T_map_base_link), place.mean_weight,
                1e-9);
  EXPECT_LT(search.mean_weight(ends, kHere, 100, {6.0, 5.0, 2.0}), places.front().mean_weight);
  EXPECT_LT(search.mean_weight(ends, kHere, 100, {900.0, -900.0, 0.0}), -1.0) << "off the map";
  EXPECT_LT(search.mean_weight({}, kHere, 100, {6.0, 5.0, 0.4}), -1.0) << "nothing seen";
}

TEST(PlaceSearch, LeavesOutPlacesFarBelowTheBest) {
  const PlaceSearch search(room_classes());
  const std::vector<Point2> ends = ends_at(testing::figure7_room(), {6.0, 5.0, 0.4});
  const std::vector<Place> all =
      search.find(ends, kHere, {.min_mean_weight = -1.0, .max_mean_gap = 2.0});
  ASSERT_GT(all.size(), 1U);
  const double gap = 0.5 * (all[0].mean_weight - all[1].mean_weight);
  const std::vector<Place> best =
      search.find(ends, kHere, {.min_mean_weight = -1.0, .max_mean_gap = gap});
  ASSERT_EQ(best.size(), 1U);
  EXPECT_EQ(best[0].T_map_base_link, all[0].T_map_base_link);
}

TEST(PlaceSearch, GivesAtMostAsManyPlacesAsAsked) {
  const PlaceSearch search(room_classes());
  const std::vector<Point2> ends = ends_at(testing::figure7_room(), {6.0, 5.0, 0.4});
  const std::vector<Place> all =
      search.find(ends, kHere, {.min_mean_weight = -1.0, .max_mean_gap = 2.0});
  const std::vector<Place> two =
      search.find(ends, kHere, {.min_mean_weight = -1.0, .max_mean_gap = 2.0, .max_places = 2});
  ASSERT_EQ(two.size(), 2U);
  EXPECT_EQ(two[0].T_map_base_link, all[0].T_map_base_link);
  EXPECT_EQ(two[1].T_map_base_link, all[1].T_map_base_link);
}

TEST(PlaceSearch, ASpentBudgetEndsTheSearch) {
  const PlaceSearch search(room_classes());
  const std::vector<Point2> ends = ends_at(testing::figure7_room(), {6.0, 5.0, 0.4});
  const auto found = [&](std::size_t expansions) {
    return search
        .find(ends, kHere,
              {.min_mean_weight = -1.0, .max_mean_gap = 2.0, .max_expansions = expansions})
        .size();
  };
  EXPECT_EQ(found(0), 0U);
  EXPECT_LE(found(50), found(150'000));
}

TEST(PlaceSearch, AForeignPlaceScoresLow) {
  const PlaceSearch search(room_classes());
  const SceneBuilder elsewhere = SceneBuilder().room({0, 0}, {3.0, 17.0});
  const std::vector<Place> own = search.find(ends_at(testing::figure7_room(), {6.0, 5.0, 0.4}),
                                             kHere, {.min_mean_weight = -1.7});
  const std::vector<Place> foreign =
      search.find(ends_at(elsewhere, {1.5, 6.0, 0.3}), kHere, {.min_mean_weight = -1.7});
  ASSERT_FALSE(own.empty());
  ASSERT_FALSE(foreign.empty());
  EXPECT_LT(foreign.front().mean_weight, own.front().mean_weight - 0.3);
}

TEST(PlaceSearch, AnEmptyMapHasNoPlaces) {
  const PlaceSearch search(class_field_of(OccupancyGrid{}));
  EXPECT_TRUE(search.find(kHere, kHere, {.min_mean_weight = -10.0}).empty());
}

TEST(PlaceSearch, WithoutEndsThereAreNoPlaces) {
  EXPECT_TRUE(PlaceSearch(room_classes()).find({}, kHere, {.min_mean_weight = -10.0}).empty());
}

TEST(PlaceSearch, AMapSmallerThanABlockIsSearched) {
  OccupancyGrid grid = testing::unknown_grid({2.0, 1.0, 0.0}, {0.3, 0.25}, 0.05);
  std::ranges::fill(grid.cells, Cell::kFree);
  grid.cells[grid.offset({4, 2})] = Cell::kOccupied;
  const PlaceSearch search(class_field_of(grid));
  const std::vector<Place> places = search.find(kHere, {}, {});
  ASSERT_FALSE(places.empty());
  EXPECT_LT(distance(places.front().T_map_base_link, {2.225, 1.125, 0.0}), 0.45);
}

TEST(PlaceSearch, AMapWithoutWallsIsNoPlaceForEnds) {
  OccupancyGrid grid = testing::unknown_grid({}, {5.0, 5.0}, 0.05);
  std::ranges::fill(grid.cells, Cell::kFree);
  EXPECT_TRUE(PlaceSearch(class_field_of(grid))
                  .find(ends_at(testing::figure7_room(), {6.0, 5.0, 0.0}), kHere, {})
                  .empty());
}

TEST(PlaceSearch, PointsTooFarAwayAreLeftOut) {
  const PlaceSearch search(room_classes());
  const Pose2 truth{6.0, 5.0, 0.4};
  std::vector<Point2> ends = ends_at(testing::figure7_room(), truth);
  ends.resize(100);
  ends.insert(ends.begin() + 50, {Point2(400.0, 0.0), Point2(-3e4, 7e4)});
  const std::vector<Point2> way{{-60.0, 5.0}, {0.0, 0.0}};
  for (const Place& place : search.find(ends, way, {.max_points = 200})) {
    EXPECT_TRUE(std::isfinite(place.mean_weight));
  }
  EXPECT_TRUE(search.find(std::vector<Point2>{{1e7, 0.0}, {-1e7, 0.0}}, kHere, {}).empty());
}

/// A lidar mounted far from base_link: where the robot would be cannot be looked up.
TEST(PlaceSearch, EndsTooFarFromTheRobotHaveNoPlace) {
  for (const double resolution : {0.05, 0.134}) {
    const PlaceSearch search(room_classes(resolution));
    for (const double offset : {22.0, 31.0, 33.0, 500.0, 1e8}) {
      std::vector<Point2> ends = ends_at(testing::figure7_room(), {6.0, 5.0, 0.4});
      for (Point2& end : ends) end += Point2{0.0, offset};
      for (const Place& place : search.find(ends, kHere, {.min_mean_weight = -1.2}))
        EXPECT_TRUE(std::isfinite(place.T_map_base_link.x));
      EXPECT_TRUE(std::isfinite(search.mean_weight(ends, kHere, 100, {6.0, 5.0, 0.4})));
    }
  }
}

/// What could not be looked for must not pass for what is nowhere.
TEST(PlaceSearch, ASearchThatCouldNotLookExcludesNothing) {
  const PlaceSearch search(room_classes());
  std::vector<Point2> ends = ends_at(testing::figure7_room(), {6.0, 5.0, 0.4});
  for (Point2& end : ends) end += Point2{0.0, 500.0};
  for (const std::vector<Point2>& seen : {ends, std::vector<Point2>{}}) {
    PlaceSearch::Run run(search, seen, kHere, {});
    WorkBudget unbounded;
    EXPECT_FALSE(run.next(-0.5, unbounded));
    EXPECT_GT(run.bound(), 0.4);
  }
}

TEST(PlaceSearch, ASpentBudgetTellsWhatMayBeLeft) {
  const PlaceSearch search(room_classes());
  const std::vector<Point2> ends = ends_at(testing::figure7_room(), {6.0, 5.0, 0.4});
  const auto places_of = [](PlaceSearch::Run& run, double least) {
    std::vector<Place> places;
    WorkBudget unbounded;
    while (const std::optional<Place> place = run.next(least, unbounded)) places.push_back(*place);
    return places;
  };
  PlaceSearch::Run whole(search, ends, kHere, {});
  PlaceSearch::Run spent(search, ends, kHere, {.max_expansions = 50});
  const std::vector<Place> all = places_of(whole, 0.0);
  const std::vector<Place> some = places_of(spent, 0.0);
  ASSERT_LT(some.size(), all.size());
  EXPECT_GE(spent.bound(), all[some.size()].mean_weight - 1e-9);
  EXPECT_LT(whole.bound(), 0.0);
}

/// Each call gets a budget of a few operations, so that it is interrupted at every point.
TEST(PlaceSearch, ASearchInManySmallPartsFindsTheSamePlaces) {
  const PlaceSearch search(room_classes());
  const std::vector<Point2> ends = ends_at(testing::figure7_room(), {6.0, 5.0, 0.4});
  PlaceSearch::Run at_once(search, ends, kHere, {});
  PlaceSearch::Run in_parts(search, ends, kHere, {});
  WorkBudget unbounded;
  int parts = 0;
  std::size_t places = 0;
  const auto next_in_parts = [&] {
    while (true) {
      WorkBudget budget(1e-5);
      const std::optional<Place> place = in_parts.next(0.0, budget);
      ++parts;
      if (place || !budget.is_spent()) return place;
    }
  };
  while (const std::optional<Place> expected = at_once.next(0.0, unbounded)) {
    const std::optional<Place> place = next_in_parts();
    ASSERT_TRUE(place.has_value());
    EXPECT_EQ(place->T_map_base_link, expected->T_map_base_link);
    EXPECT_EQ(place->mean_weight, expected->mean_weight);
    ++places;
  }
  EXPECT_FALSE(next_in_parts());
  EXPECT_GT(places, 1U);
  EXPECT_GT(parts, 180);
}

/// A long corridor seen from its end: the points reach to the border of what the search can lay.
TEST(PlaceSearch, FarPointsWithinReachAreFound) {
  const SceneBuilder scene = SceneBuilder()
                                 .room({0, 0}, {50.0, 3.0})
                                 .box({10.0, 0.5}, {1.0, 1.0})
                                 .box({33.0, 2.6}, {2.0, 0.8});
  const PlaceSearch search(
      class_field_of(testing::drawn_grid(scene, {1, 1}, {-1.0, -1.0, 0.0}, {52.0, 5.0}, 0.05)));
  std::vector<Point2> ends;
  const Pose2 truth{2.0, 1.6, 0.1};
  for (const Point2& p : returns_as_points(
           testing::simulate_scan(scene, {.beams = 1440, .range_max_m = 60.0}, truth))) {
    ends.push_back(p);
  }
  const std::vector<Place> places = search.find(ends, kHere, {.max_points = 400});
  ASSERT_FALSE(places.empty());
  EXPECT_THAT(places.front().T_map_base_link, IsPoseNear(truth, 0.6, 0.07));
}

/// Nothing is lost by asking little at first, nor where there is too much to look at all at once.
TEST(PlaceSearch, ALookThatGoesDeeperFindsWhatADeepOneDoes) {
  const SceneBuilder scene =
      SceneBuilder().room({0, 0}, {25.0, 15.0}).box({12.0, 10.0}, {2.0, 1.0}, 0.4);
  const PlaceSearch search(
      class_field_of(testing::drawn_grid(scene, {1, 1}, {-1.0, -1.0, 0.0}, {27.0, 17.0}, 0.05)));
  const std::vector<Point2> ends = ends_at(scene, {9.0, 12.0, 0.4});
  const auto places_by = [&](const std::vector<double>& limits) {
    PlaceSearch::Run run(search, ends, kHere, {});
    std::vector<Place> places;
    WorkBudget unbounded;
    for (const double least : limits) {
      while (const std::optional<Place> place = run.next(least, unbounded))
        places.push_back(*place);
    }
    return places;
  };
  const std::vector<Place> deep = places_by({-0.2});
  const std::vector<Place> deeper = places_by({0.3, 0.1, -0.1, -0.2});
  ASSERT_GT(deep.size(), 60U);
  EXPECT_TRUE(std::ranges::is_sorted(deep, std::greater{}, &Place::mean_weight));
  // Which of equal neighbours comes first, and keeps the others away, is a matter of the order.
  EXPECT_NEAR(static_cast<double>(deeper.size()) / static_cast<double>(deep.size()), 1.0, 0.02);
  for (std::size_t i = 0; i < 50; ++i)
    EXPECT_NEAR(deeper[i].mean_weight, deep[i].mean_weight, 1e-9) << i;
}

TEST(PlaceSearch, SameInputSamePlaces) {
  const PlaceSearch search(room_classes());
  const std::vector<Point2> ends = ends_at(testing::figure7_room(), {6.0, 5.0, 0.4});
  const std::vector<Place> one = search.find(ends, kHere, {});
  const std::vector<Place> two = PlaceSearch(room_classes()).find(ends, kHere, {});
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].T_map_base_link, two[i].T_map_base_link);
    EXPECT_EQ(one[i].mean_weight, two[i].mean_weight);
  }
}

TEST(PlaceSearch, FindsPosesOfItsRegionOnly) {
  for (const double yaw : {0.0, -0.7}) {
    const PlaceSearch search(room_classes(0.05, yaw));
    const Pose2 truth{6.5, 5.5, 2.0};
    const Pose2 motion{1.0, 0.5, 0.4};
    const Pose2 T_map_start = truth * inverse(motion);
    const std::vector<Point2> ends = ends_at(testing::figure7_room(), truth);
    const auto places_about = [&](const Point2& center) {
      const StartRegion start{
          .center = center, .radius_m = 0.8, .yaw = T_map_start.yaw, .yaw_tolerance_rad = 0.9};
      const SearchRegion region(start, motion);
      const PlaceSearchParams params{
          .min_mean_weight = -1.0, .max_mean_gap = 2.0, .region = region};
      const std::vector<Place> places = search.find(ends, kHere, params);
      EXPECT_TRUE(std::ranges::all_of(places, [&](const Place& place) {
        return region.contains(place.T_map_base_link, 0.15, 0.02);
      }));
      return places;
    };
    const std::vector<Place> here = places_about(T_map_start.translation());
    ASSERT_FALSE(here.empty()) << yaw;
    EXPECT_THAT(here.front().T_map_base_link, IsPoseNear(truth, 0.35, 0.07)) << yaw;
    const std::vector<Place> beside = places_about(T_map_start.translation() - Point2(1.5, 0.0));
    ASSERT_FALSE(beside.empty()) << yaw;
    EXPECT_LT(beside.front().mean_weight, here.front().mean_weight) << yaw;
  }
}

}  // namespace
}  // namespace cornerfix

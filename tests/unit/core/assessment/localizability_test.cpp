#include <cornerfix/localizability.hpp>

#include <gtest/gtest.h>

#include <algorithm>

#include "support/floor_plans.hpp"
#include "support/mapped_floor.hpp"

namespace cornerfix {
namespace {

using testing::mapped_floor;

LocalizabilityReport assess(const LocalizationMapPtr& map, LocalizabilityParams params = {}) {
  auto report = assess_localizability(map, params);
  EXPECT_TRUE(report.has_value());
  return report.value_or(LocalizabilityReport{});
}

LocalizationMapPtr offices_to_assess() {
  return mapped_floor(testing::offices(), {{1.0, 1.0}}, {16, 9});
}

TEST(Localizability, FindsEveryRobotInARoomLikeNoOther) {
  const LocalizabilityReport report = assess(
      mapped_floor(testing::random_room(3), {{0.0, 0.0}}, {14, 14}, {-7, -7}), {.max_places = 8});
  ASSERT_GE(report.places.size(), 4U);
  for (const AssessedPlace& place : report.places) {
    for (const AssessedStart& start : place.starts) {
      EXPECT_TRUE(start.way_m.has_value()) << place.position_map.transpose();
      EXPECT_FALSE(start.is_wrong);
    }
  }
  EXPECT_NEAR(report.free_area_m2, 90.0, 40.0);
}

TEST(Localizability, NamesTheRoomThatAnswersForAnother) {
  const LocalizabilityReport report = assess(
      mapped_floor(testing::equal_rooms(), {{2.0, 2.0}, {22.0, 2.0}}, {30, 6}), {.max_places = 4});
  ASSERT_FALSE(report.places.empty());
  for (const AssessedPlace& place : report.places)
    EXPECT_EQ(expected_way_m(place, report.way_limit_m), report.way_limit_m);
  ASSERT_FALSE(report.look_alikes.empty());
  for (const AliasedPoses& pair : report.look_alikes) {
    EXPECT_NEAR(std::abs(pair.T_map_a.x - pair.T_map_b.x), 20.0, 0.5);
    EXPECT_NEAR(pair.T_map_a.y, pair.T_map_b.y, 0.5);
    EXPECT_NEAR(angle_between(pair.T_map_a, pair.T_map_b), 0.0, 0.15);
  }
}

TEST(Localizability, LetsFewPlacesStandForAllOfTheMap) {
  const LocalizabilityReport report = assess(offices_to_assess(), {.max_places = 6});
  EXPECT_LE(report.places.size(), 6U);
  EXPECT_GT(report.lattice_m, 1.5);
  const auto [low, high] = std::ranges::minmax(
      report.places, {}, [](const AssessedPlace& place) { return place.position_map.x(); });
  EXPECT_GT(high.position_map.x() - low.position_map.x(), 8.0);
}

TEST(Localizability, IsTheSameWheneverItIsAsked) {
  const LocalizationMapPtr map = offices_to_assess();
  const LocalizabilityReport first = assess(map, {.max_places = 2});
  const LocalizabilityReport second = assess(map, {.max_places = 2});
  ASSERT_EQ(first.places.size(), second.places.size());
  for (std::size_t i = 0; i < first.places.size(); ++i) {
    for (std::size_t k = 0; k < first.places[i].starts.size(); ++k) {
      EXPECT_EQ(first.places[i].starts[k].way_m, second.places[i].starts[k].way_m);
      EXPECT_EQ(first.places[i].starts[k].confidence, second.places[i].starts[k].confidence);
    }
  }
}

TEST(Localizability, SeesLessWithALidarOfShortReach) {
  const LocalizationMapPtr map = mapped_floor(testing::bare_hall(), {{2.0, 2.0}}, {40, 20});
  LocalizabilityParams near_sighted{.max_places = 3};
  near_sighted.robot.lidar.range_max = 3.0;
  const auto mean_confidence = [&](const LocalizabilityParams& params) {
    double sum = 0.0;
    double starts = 0.0;
    for (const AssessedPlace& place : assess(map, params).places) {
      for (const AssessedStart& start : place.starts) {
        sum += start.confidence;
        ++starts;
      }
    }
    return sum / starts;
  };
  EXPECT_LT(mean_confidence(near_sighted) + 0.1, mean_confidence({.max_places = 3}));
}

TEST(Localizability, EndsWhenItIsToldTo) {
  int reports = 0;
  const auto report =
      assess_localizability(offices_to_assess(), {}, [&reports](double) { return ++reports < 2; });
  EXPECT_FALSE(report.has_value());
  EXPECT_EQ(reports, 2);
}

TEST(Localizability, HasNoPlacesWhereTheMapHasNoFreeSpace) {
  MapContent content;
  content.grid = testing::unknown_grid({}, {4.0, 4.0}, 0.05);
  const LocalizabilityReport report =
      assess(std::make_shared<const LocalizationMap>("dark", 1, std::move(content)));
  EXPECT_TRUE(report.places.empty());
  EXPECT_EQ(report.free_area_m2, 0.0);
}

}  // namespace
}  // namespace cornerfix

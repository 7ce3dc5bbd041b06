#include <cornerfix/localizability.hpp>

#include <gtest/gtest.h>

namespace cornerfix {
namespace {

AssessedPlace place_at(const Point2& position, std::optional<double> way_m,
                       std::optional<Pose2> rival = {}) {
  AssessedStart start;
  start.T_map_base_link = {position.x(), position.y(), 0.0};
  start.way_m = way_m;
  start.rival = rival;
  return {position, 0, {start}};
}

/// A row of places 2 m apart.
LocalizabilityReport report_of(std::vector<AssessedPlace> places) {
  LocalizabilityReport report;
  report.way_limit_m = 20.0;
  report.lattice_m = 2.0;
  report.places = std::move(places);
  return report;
}

TEST(LowLocalizability, AreNoneWhereRobotsAreFoundAtOnce) {
  EXPECT_TRUE(
      find_low_localizability_regions(report_of({place_at({0, 0}, 0.0), place_at({2, 0}, 2.5)}))
          .empty());
}

TEST(LowLocalizability, JoinNeighboursAndTellWhatTheyNeed) {
  const auto areas = find_low_localizability_regions(
      report_of({place_at({0, 0}, 0.0), place_at({2, 0}, 4.0), place_at({4, 0}, {}),
                 place_at({6, 0}, 0.0), place_at({20, 0}, 5.0)}));
  ASSERT_EQ(areas.size(), 2U);
  EXPECT_EQ(areas[0].places, (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(areas[0].center_map, Point2(3, 0));
  EXPECT_DOUBLE_EQ(areas[0].way_m, 12.0);
  EXPECT_DOUBLE_EQ(areas[0].found, 0.5);
  EXPECT_DOUBLE_EQ(areas[0].radius_m, 1.0);
  EXPECT_EQ(areas[1].places, (std::vector<std::size_t>{4}));
}

TEST(LowLocalizability, SendRobotsToTheNearestPlaceWhereStandingIsEnough) {
  const auto areas = find_low_localizability_regions(report_of(
      {place_at({0, 0}, 0.0), place_at({3, 0}, 2.0), place_at({5, 0}, {}), place_at({9, 0}, 0.0)}));
  ASSERT_EQ(areas.size(), 1U);
  EXPECT_EQ(areas[0].easy_map, Point2(9, 0));
}

TEST(LowLocalizability, NameTheOtherPlaceOnlyWhereItIsTheReason) {
  const Pose2 twin{30.0, 1.0, 0.0};
  const auto alike = find_low_localizability_regions(report_of({place_at({0, 0}, {}, twin)}));
  ASSERT_EQ(alike.size(), 1U);
  EXPECT_EQ(alike[0].look_alike_map, Point2(30, 1));
  const auto bare = find_low_localizability_regions(
      report_of({place_at({0, 0}, {}), place_at({2, 0}, {}), place_at({4, 0}, 9.0, twin)}));
  ASSERT_EQ(bare.size(), 1U);
  EXPECT_FALSE(bare[0].look_alike_map);
}

}  // namespace
}  // namespace cornerfix

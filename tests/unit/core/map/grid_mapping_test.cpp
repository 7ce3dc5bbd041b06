#include <cornerfix/mapper.hpp>

#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "support/drawn_grid.hpp"
#include "support/floor_plans.hpp"
#include "support/matchers.hpp"
#include "support/simulated_drive.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

OccupancyGrid floor_map_of(const testing::SceneBuilder& scene,
                           const Pose2& T_map_grid = {-1, -1, 0}, double resolution = 0.05) {
  return testing::drawn_grid(scene, {1.0, 1.0}, T_map_grid, {19.0, 12.0}, resolution);
}

GridMap map_of(const OccupancyGrid& floor_map) {
  Result<GridMap> map = map_from_grid(floor_map, {});
  EXPECT_TRUE(map) << map.error().message;
  return map ? std::move(*map) : GridMap{};
}

/// The last answer to a run through the offices.
Answer localize_in(const GridMap& map) {
  const testing::SceneBuilder scene = testing::offices();
  Localizer localizer({std::make_shared<const LocalizationMap>("offices", 1, map.content)},
                      LocalizerParams{});
  Answer answer;
  for (const testing::Moment& moment :
       testing::drive(scene, testing::Robot{}, testing::drive_through_offices(), 1)) {
    answer = localizer.process(moment.scan);
    if (answer.status != Status::kLocalized) continue;
    EXPECT_THAT(answer.pose->T_map_base_link,
                testing::IsPoseNear(moment.T_map_base_link, 0.06, 0.01));
  }
  return answer;
}

/// Corners of the offices that `map` has within 0.15 m.
std::size_t corners_found(const GridMap& map, std::span<const Point2> corners) {
  return static_cast<std::size_t>(
      std::count_if(corners.begin(), corners.end(), [&](const Point2& c) {
        return std::any_of(map.content.features.begin(), map.content.features.end(),
                           [&](const Feature& f) { return (f.position - c).norm() < 0.15; });
      }));
}

TEST(GridMapping, ReportsItsStagesInTheirOrderWithGrowingShares) {
  std::vector<std::pair<GridMapStage, double>> reports;
  const Result<GridMap> map =
      map_from_grid(floor_map_of(testing::offices()), {}, [&](GridMapStage stage, double share) {
        reports.emplace_back(stage, share);
        return true;
      });
  ASSERT_TRUE(map);
  EXPECT_EQ(map->content.features.size(),
            map_of(floor_map_of(testing::offices())).content.features.size());
  EXPECT_TRUE(std::ranges::is_sorted(reports));
  ASSERT_GE(reports.size(), 3U);
  EXPECT_EQ(reports.front().first, GridMapStage::kWalls);
  EXPECT_EQ(reports.back().first, GridMapStage::kDescriptors);
}

TEST(GridMapping, GivesUpInAnyStage) {
  for (const GridMapStage last :
       {GridMapStage::kWalls, GridMapStage::kFeatures, GridMapStage::kDescriptors}) {
    const Result<GridMap> map =
        map_from_grid(floor_map_of(testing::offices()), {},
                      [&](GridMapStage stage, double /*share*/) { return stage != last; });
    ASSERT_FALSE(map);
    EXPECT_EQ(map.error().code, ErrorCode::kUnavailable);
  }
}

TEST(GridMapping, ARobotFindsItselfInAFloorMapWithoutAnyScan) {
  EXPECT_EQ(localize_in(map_of(floor_map_of(testing::offices()))).status, Status::kLocalized);
}

TEST(GridMapping, ARobotFindsItselfInATurnedFloorMap) {
  const Pose2 T_map_grid{8.0, -9.0, 0.8};
  const OccupancyGrid turned =
      testing::drawn_grid(testing::offices(), {1.0, 1.0}, T_map_grid, {24.0, 24.0}, 0.05);
  EXPECT_EQ(localize_in(map_of(turned)).status, Status::kLocalized);
}

TEST(GridMapping, FeaturesAreTheCornersOfTheBuilding) {
  const GridMap map = map_of(floor_map_of(testing::offices()));
  const Point2 corners[] = {{0, 0}, {16, 0}, {0, 9}, {16, 9}, {5, 9}, {11, 9}};
  EXPECT_EQ(corners_found(map, corners), std::size(corners));
  EXPECT_EQ(map.content.descriptors.size(), map.content.features.size());
  EXPECT_THAT(map.warnings, IsEmpty());
}

/// However its views are shared out among threads.
TEST(GridMapping, TheSameFloorMapMakesTheSameMap) {
  const OccupancyGrid floor_map = floor_map_of(testing::offices());
  const MapContent first = map_of(floor_map).content;
  for (int again = 0; again < 5; ++again) {
    const MapContent next = map_of(floor_map).content;
    ASSERT_EQ(next.features.size(), first.features.size());
    for (std::size_t i = 0; i < first.features.size(); ++i) {
      EXPECT_EQ(next.features[i].position, first.features[i].position);
      EXPECT_EQ(next.features[i].bisector, first.features[i].bisector);
      EXPECT_EQ(next.features[i].count, first.features[i].count);
    }
    EXPECT_EQ(next.descriptors.entries, first.descriptors.entries);
    EXPECT_EQ(next.grid, first.grid);
  }
}

TEST(GridMapping, GreyRimsHideNoCorner) {
  OccupancyGrid floor_map = floor_map_of(testing::offices());
  const OccupancyGrid sharp = floor_map;
  for (int row = 0; row < sharp.height; ++row) {
    for (int column = 0; column < sharp.width; ++column) {
      if (sharp.at({column, row}) != Cell::kFree) continue;
      for (const CellIndex next : {CellIndex{column + 1, row}, CellIndex{column - 1, row},
                                   CellIndex{column, row + 1}, CellIndex{column, row - 1}}) {
        if (sharp.at(next) == Cell::kOccupied)
          floor_map.cells[floor_map.offset({column, row})] = Cell::kUnknown;
      }
    }
  }
  const Point2 corners[] = {{0, 0}, {16, 0}, {0, 9}, {16, 9}, {5, 9}, {11, 9}};
  EXPECT_EQ(corners_found(map_of(floor_map), corners), std::size(corners));
}

TEST(GridMapping, ASlantingWallIsNoStaircaseOfCorners) {
  const testing::SceneBuilder scene = testing::SceneBuilder()
                                          .wall({0, 0}, {15, 2})
                                          .wall({15, 2}, {14, 9})
                                          .wall({14, 9}, {-1, 7})
                                          .wall({-1, 7}, {0, 0});
  EXPECT_LE(map_of(floor_map_of(scene, {-2, -1, 0})).content.features.size(), 5U);
}

TEST(GridMapping, ThickWallsAreSaid) {
  OccupancyGrid floor_map = testing::unknown_grid({}, {4.0, 4.0}, 0.05);
  for (int row = 0; row < floor_map.height; ++row) {
    for (int column = 0; column < floor_map.width; ++column) {
      const bool inside =
          std::min({row, column, floor_map.height - 1 - row, floor_map.width - 1 - column}) >= 5;
      floor_map.cells[floor_map.offset({column, row})] = inside ? Cell::kFree : Cell::kOccupied;
    }
  }
  const GridMap map = map_of(floor_map);
  ASSERT_EQ(map.warnings.size(), 1U);
  EXPECT_THAT(map.warnings[0], HasSubstr("walls are 0.25 m thick"));
}

TEST(GridMapping, SaysWhenNoRobotHasRoomInIt) {
  OccupancyGrid tiny = floor_map_of(testing::offices());
  tiny.resolution = 0.002;  // a slip of the pen: it is 0.05
  const GridMap map = map_of(tiny);
  ASSERT_EQ(map.warnings.size(), 1U);
  EXPECT_THAT(map.warnings[0], HasSubstr("room to move"));
  EXPECT_THAT(map.content.features, IsEmpty());
}

TEST(GridMapping, MapsWithoutFreeSpaceOrWallsAreRefused) {
  OccupancyGrid floor_map = testing::unknown_grid({}, {1.0, 1.0}, 0.05);
  EXPECT_THAT(map_from_grid(floor_map, {}).error().message, HasSubstr("no free cell"));
  floor_map.cells.assign(floor_map.cells.size(), Cell::kFree);
  EXPECT_THAT(map_from_grid(floor_map, {}).error().message, HasSubstr("no occupied cell"));
}

/// Free, with an occupied cell at each corner of squares of `spacing` cells.
OccupancyGrid pillars(int side, int spacing) {
  OccupancyGrid grid{
      .resolution = 0.05, .T_map_grid = {}, .width = side, .height = side, .cells = {}};
  grid.cells.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), Cell::kFree);
  for (int row = 0; row < side; row += spacing) {
    for (int column = 0; column < side; column += spacing)
      grid.cells[grid.offset({column, row})] = Cell::kOccupied;
  }
  return grid;
}

TEST(GridMapping, NoiseIsRefused) {
  const auto refused = map_from_grid(pillars(600, 8), {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "image");
  EXPECT_THAT(refused.error().message, HasSubstr("5625 separate pieces"));
}

TEST(GridMapping, PillarsOfAHallAreNoNoise) { EXPECT_TRUE(map_from_grid(pillars(300, 100), {})); }

TEST(GridMapping, ASingleCellIsNoMap) {
  OccupancyGrid floor_map = testing::unknown_grid({}, {0.05, 0.05}, 0.05);
  for (const Cell cell : {Cell::kFree, Cell::kOccupied, Cell::kUnknown}) {
    floor_map.cells.assign(1, cell);
    EXPECT_FALSE(map_from_grid(floor_map, {}));
  }
}

}  // namespace
}  // namespace cornerfix

#include "evaluation/simulation/scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace cornerfix::evaluation {
namespace {

/// Cells that a robot of 0.3 m radius may stand in: all within 6 cells on each axis are free.
std::vector<bool> standing_room(const OccupancyGrid& grid) {
  constexpr int kRadius = 6;
  const auto filter = [&](std::vector<bool> in, int size, int lines, auto index) {
    std::vector<bool> out(in.size(), false);
    for (int line = 0; line < lines; ++line) {
      int run = 0;  // of true cells up to here
      for (int i = 0; i < size; ++i) {
        run = in[index(i, line)] ? run + 1 : 0;
        if (run > 2 * kRadius) out[index(i - kRadius, line)] = true;
      }
    }
    return out;
  };
  std::vector<bool> room(grid.cells.size());
  std::transform(grid.cells.begin(), grid.cells.end(), room.begin(),
                 [](Cell c) { return c == Cell::kFree; });
  const auto row_wise = [&](int i, int line) { return grid.offset({i, line}); };
  const auto column_wise = [&](int i, int line) { return grid.offset({line, i}); };
  room = filter(room, grid.width, grid.height, row_wise);
  return filter(room, grid.height, grid.width, column_wise);
}

/// Sizes of the connected parts of a mask, largest first.
std::vector<std::size_t> parts_of(std::vector<bool> mask, int width) {
  std::vector<std::size_t> sizes;
  const auto w = static_cast<std::size_t>(width);
  for (std::size_t start = 0; start < mask.size(); ++start) {
    if (!mask[start]) continue;
    std::vector<std::size_t> open{start};
    mask[start] = false;
    for (std::size_t next = 0; next < open.size(); ++next) {
      for (const std::size_t to :
           {open[next] - 1, open[next] + 1, open[next] - w, open[next] + w}) {
        if (to >= mask.size() || !mask[to]) continue;
        mask[to] = false;
        open.push_back(to);
      }
    }
    sizes.push_back(open.size());
  }
  std::ranges::sort(sizes, std::ranges::greater());
  return sizes;
}

double occupied_share(const OccupancyGrid& grid) {
  return static_cast<double>(std::ranges::count(grid.cells, Cell::kOccupied)) /
         static_cast<double>(grid.cells.size());
}

/// In each row, the first occupied cell: the outer walls.
std::vector<int> outline(const OccupancyGrid& grid) {
  std::vector<int> first(static_cast<std::size_t>(grid.height), -1);
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width && first[static_cast<std::size_t>(row)] < 0;
         ++column) {
      if (grid.at({column, row}) == Cell::kOccupied) first[static_cast<std::size_t>(row)] = column;
    }
  }
  return first;
}

class Scenes : public ::testing::TestWithParam<SceneKind> {};

TEST_P(Scenes, AreTheSameForTheSameSeeds) {
  EXPECT_EQ(make_scene(GetParam(), 5, 6), make_scene(GetParam(), 5, 6));
}

TEST_P(Scenes, DifferInSizeOrWallsByTheLayoutSeed) {
  EXPECT_NE(outline(make_scene(GetParam(), 1, 1)), outline(make_scene(GetParam(), 2, 1)));
}

TEST_P(Scenes, KeepTheirWallsWhenTheyChange) {
  for (const std::uint64_t layout : {1U, 2U}) {
    const OccupancyGrid before = make_scene(GetParam(), layout, 1);
    const OccupancyGrid after = make_scene(GetParam(), layout, 2);
    EXPECT_EQ(before.T_map_grid, after.T_map_grid);
    ASSERT_EQ(before.width, after.width);
    ASSERT_EQ(before.height, after.height);
    EXPECT_NE(before, after);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < before.cells.size(); ++i)
      kept += before.cells[i] == Cell::kOccupied && after.cells[i] == Cell::kOccupied ? 1 : 0;
    const double occupied = occupied_share(before) * static_cast<double>(before.cells.size());
    EXPECT_GT(static_cast<double>(kept), 0.5 * occupied);
    if (GetParam() == SceneKind::kYard) continue;  // parked cars may stand outermost
    EXPECT_EQ(outline(before), outline(after));
  }
}

TEST_P(Scenes, HaveOneFreeSpaceThatRobotsCanDriveThrough) {
  const OccupancyGrid grid = make_scene(GetParam(), 3, 1);
  std::vector<bool> free(grid.cells.size());
  std::transform(grid.cells.begin(), grid.cells.end(), free.begin(),
                 [](Cell c) { return c == Cell::kFree; });
  EXPECT_EQ(parts_of(free, grid.width).size(), 1U);
  const std::vector<bool> room = standing_room(grid);
  const auto all = static_cast<double>(std::ranges::count(room, true));
  EXPECT_GT(all * grid.resolution * grid.resolution, 15.0);
  EXPECT_GT(static_cast<double>(parts_of(room, grid.width).front()), 0.8 * all);
}

TEST_P(Scenes, HaveWallsToSee) {
  const OccupancyGrid grid = make_scene(GetParam(), 4, 1);
  EXPECT_GT(occupied_share(grid), 0.01);
  EXPECT_LT(occupied_share(grid), 0.4);
  EXPECT_LE(grid.cells.size(), 15'000'000U);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Scenes, ::testing::ValuesIn(all_scene_kinds()),
                         [](const auto& test) { return std::string(to_string(test.param)); });

TEST(SceneKind, HasAName) {
  for (const SceneKind kind : all_scene_kinds())
    EXPECT_EQ(scene_kind_from_string(to_string(kind)), kind);
  EXPECT_EQ(scene_kind_from_string("castle"), std::nullopt);
}

}  // namespace
}  // namespace cornerfix::evaluation

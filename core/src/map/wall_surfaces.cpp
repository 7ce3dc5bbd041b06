#include "core/src/map/wall_surfaces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace cornerfix {
namespace {

constexpr double kMargin = 0.5;        // unknown space kept around what is known [m]
constexpr double kMaxThickness = 1.0;  // [m]
constexpr std::array<CellIndex, 4> kNeighbors{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

CellIndex operator+(CellIndex a, CellIndex b) { return {a.column + b.column, a.row + b.row}; }

/// Steps from the nearest cell of `from` through unknown cells, by cell; 0 where there is none
/// within `max_steps`.
std::vector<std::uint8_t> steps_into_unknown(const OccupancyGrid& grid, Cell from, int max_steps) {
  std::vector<std::uint8_t> steps(grid.cells.size(), 0);
  std::vector<CellIndex> reached;
  const auto reach_beside = [&](CellIndex cell, int step) {
    for (const CellIndex& to : kNeighbors) {
      const CellIndex next = cell + to;
      if (!grid.contains(next) || grid.at(next) != Cell::kUnknown) continue;
      std::uint8_t& known = steps[grid.offset(next)];
      if (known != 0) continue;
      known = static_cast<std::uint8_t>(step);
      reached.push_back(next);
    }
  };
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      if (grid.at({column, row}) == from) reach_beside({column, row}, 1);
    }
  }
  for (std::size_t begin = 0, step = 2; step <= static_cast<std::size_t>(max_steps); ++step) {
    const std::size_t end = reached.size();
    for (std::size_t i = begin; i < end; ++i) reach_beside(reached[i], static_cast<int>(step));
    begin = end;
  }
  return steps;
}

/// Columns and rows of what is known, the last ones not included.
struct CellBox {
  CellIndex first{0, 0};
  CellIndex end{0, 0};
};

CellBox known_box(const OccupancyGrid& grid) {
  CellBox box{{grid.width, grid.height}, {0, 0}};
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      if (grid.at({column, row}) == Cell::kUnknown) continue;
      box.first = {std::min(box.first.column, column), std::min(box.first.row, row)};
      box.end = {std::max(box.end.column, column + 1), std::max(box.end.row, row + 1)};
    }
  }
  return box.end.column == 0 ? CellBox{} : box;
}

/// How deep walls are behind each border to free space, in the middle of all. Straight in: what
/// stands at an angle looks thicker.
double median_thickness(const OccupancyGrid& grid) {
  const int max_cells = std::max(1, static_cast<int>(kMaxThickness / grid.resolution));
  std::vector<std::size_t> borders(static_cast<std::size_t>(max_cells) + 1, 0);
  std::size_t all = 0;
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      if (grid.at({column, row}) != Cell::kFree) continue;
      for (const CellIndex& to : kNeighbors) {
        int depth = 0;
        CellIndex cell = CellIndex{column, row} + to;
        for (; depth < max_cells && grid.at(cell) == Cell::kOccupied; cell = cell + to) ++depth;
        if (depth == 0) continue;
        ++borders[static_cast<std::size_t>(depth)];
        ++all;
      }
    }
  }
  std::size_t below = 0;
  for (std::size_t depth = 1; depth < borders.size(); ++depth) {
    below += borders[depth];
    if (2 * below >= all && all > 0) return static_cast<double>(depth) * grid.resolution;
  }
  return 0.0;
}

/// Whether walls are taken to begin at the border of their cells, not in the middle of them. A wall
/// one cell thick is what mapping programs make: its surface is somewhere in that cell. A thicker
/// one was drawn, and in a coarse map the middle may be far off.
bool begin_at_borders(const OccupancyGrid& floor_map, double thickness_m) {
  constexpr double kFineCell = 0.075;  // [m]
  return floor_map.resolution > kFineCell || thickness_m > 1.5 * floor_map.resolution;
}

/// Draws what is known of an occupancy map in cells of about the wanted size: `parts` to a side of
/// its cells, or one to `merged` of them.
class SurfaceGrid {
 public:
  /// \param shift  0: cells of the map fall on whole cells or parts of cells; 0.5: the corners of
  /// the map's cells fall in the middle of cells.
  SurfaceGrid(const OccupancyGrid& floor_map, double resolution_m, double shift) : map_(floor_map) {
    const double ratio = floor_map.resolution / resolution_m;
    parts_ = std::max(1, static_cast<int>(std::lround(ratio)));
    merged_ = std::max(1, static_cast<int>(std::lround(1.0 / ratio)));
    round_up_ = static_cast<int>(shift * merged_);
    grid_.resolution = floor_map.resolution * merged_ / parts_;
    const int margin = static_cast<int>(std::ceil(kMargin / floor_map.resolution));
    const CellBox known = known_box(floor_map);
    first_ = {known.first.column - margin, known.first.row - margin};
    end_ = {known.end.column + margin, known.end.row + margin};
    const Point2 origin = Point2(first_.column, first_.row) * floor_map.resolution -
                          Point2::Constant(shift * grid_.resolution);
    grid_.T_map_grid = floor_map.T_map_grid * Pose2{origin.x(), origin.y(), 0.0};
  }

  [[nodiscard]] double cells() const {
    return static_cast<double>(index(end_.column, first_.column) + 1) *
           static_cast<double>(index(end_.row, first_.row) + 1);
  }

  /// Wall: cells that touch free ones. Without shift.
  OccupancyGrid draw_cells() && {
    allocate();
    for_each(Cell::kFree, [&](CellIndex cell) { mark(cell, cell, Cell::kFree); });
    for_each(Cell::kOccupied, [&](CellIndex cell) {
      if (touches_free(cell)) mark(cell, cell, Cell::kOccupied);
    });
    return std::move(grid_);
  }

  /// Wall: the sides between free and occupied cells. With a shift of half a cell.
  OccupancyGrid draw_borders() && {
    allocate();
    for_each(Cell::kFree, [&](CellIndex cell) { mark(cell, cell + CellIndex{1, 1}, Cell::kFree); });
    for_each(Cell::kFree, [&](CellIndex cell) {
      for (const CellIndex& to : kNeighbors) {
        if (map_.at(cell + to) == Cell::kOccupied) mark_border(cell, to);
      }
    });
    return std::move(grid_);
  }

 private:
  void allocate() {
    grid_.width = static_cast<int>(index(end_.column, first_.column)) + 1;
    grid_.height = static_cast<int>(index(end_.row, first_.row)) + 1;
    grid_.cells.assign(
        static_cast<std::size_t>(grid_.width) * static_cast<std::size_t>(grid_.height),
        Cell::kUnknown);
  }

  template <typename Function>
  void for_each(Cell value, Function function) const {
    for (int row = 0; row < map_.height; ++row) {
      for (int column = 0; column < map_.width; ++column) {
        if (map_.at({column, row}) == value) function(CellIndex{column, row});
      }
    }
  }

  [[nodiscard]] bool touches_free(CellIndex cell) const {
    for (const int rows_off : {-1, 0, 1}) {
      for (const int columns_off : {-1, 0, 1}) {
        if (map_.at(cell + CellIndex{columns_off, rows_off}) == Cell::kFree) return true;
      }
    }
    return false;
  }

  /// Column or row in the drawing of a column or row, or of a corner, of the occupancy map.
  [[nodiscard]] std::int64_t index(int of_map, int first) const {
    return ((static_cast<std::int64_t>(of_map) - first) * parts_ + round_up_) / merged_;
  }

  void mark(CellIndex from, CellIndex to, Cell value) {
    const auto column = static_cast<int>(index(from.column, first_.column));
    const std::int64_t width = index(to.column, first_.column) - column + 1;
    for (std::int64_t row = index(from.row, first_.row); row <= index(to.row, first_.row); ++row) {
      const std::size_t begin = grid_.offset({column, static_cast<int>(row)});
      std::fill_n(grid_.cells.begin() + static_cast<std::ptrdiff_t>(begin), width, value);
    }
  }

  /// The side of `cell` towards its neighbour.
  void mark_border(CellIndex cell, CellIndex to) {
    const CellIndex from{cell.column + (to.column > 0 ? 1 : 0), cell.row + (to.row > 0 ? 1 : 0)};
    mark(from, from + CellIndex{to.column == 0 ? 1 : 0, to.row == 0 ? 1 : 0}, Cell::kOccupied);
  }

  const OccupancyGrid& map_;
  int parts_ = 1;
  int merged_ = 1;
  int round_up_ = 0;
  CellIndex first_{0, 0};  // of the occupancy map, at the lower left of the drawing
  CellIndex end_{0, 0};
  OccupancyGrid grid_;
};

std::string too_large_text(const OccupancyGrid& floor_map, double resolution_m, double max_cells) {
  char text[240];
  std::snprintf(text, sizeof text,
                "the floor map is too large: %d x %d pixels of %.6g m are %.6g x %.6g m, at most "
                "%.6g cells of %.6g m are taken; is its resolution in metres per pixel?",
                floor_map.width, floor_map.height, floor_map.resolution,
                floor_map.width * floor_map.resolution, floor_map.height * floor_map.resolution,
                max_cells, resolution_m);
  return text;
}

}  // namespace

OccupancyGrid without_grey_rims(OccupancyGrid floor_map) {
  const int max_steps = std::clamp(static_cast<int>(kMaxRimWidth / floor_map.resolution), 1, 200);
  const auto from_free = steps_into_unknown(floor_map, Cell::kFree, max_steps);
  const auto from_wall = steps_into_unknown(floor_map, Cell::kOccupied, max_steps);
  for (std::size_t i = 0; i < floor_map.cells.size(); ++i) {
    const bool is_between = from_free[i] > 0 && from_wall[i] > 0;
    if (is_between && from_free[i] + from_wall[i] <= max_steps + 1)
      floor_map.cells[i] = Cell::kFree;
  }
  return floor_map;
}

Result<WallSurfaces> find_wall_surfaces(const OccupancyGrid& floor_map, double resolution_m,
                                        double max_cells) {
  const double thickness_m = median_thickness(floor_map);
  const bool at_borders = begin_at_borders(floor_map, thickness_m);
  SurfaceGrid surfaces(floor_map, resolution_m, at_borders ? 0.5 : 0.0);
  if (surfaces.cells() > max_cells) {
    return Error{ErrorCode::kTooLarge, too_large_text(floor_map, resolution_m, max_cells),
                 "resolution"};
  }
  OccupancyGrid grid =
      at_borders ? std::move(surfaces).draw_borders() : std::move(surfaces).draw_cells();
  return WallSurfaces{std::move(grid), thickness_m};
}

}  // namespace cornerfix

#include "evaluation/simulation/scene_canvas.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace cornerfix::evaluation {

namespace {

constexpr double kResolution = 0.05;                             // [m/cell]
constexpr double kThinnest = std::numbers::sqrt2 * kResolution;  // leaves no gap at any angle [m]
constexpr double kMargin = 0.5;                                  // [m] about the plan
constexpr std::size_t kDiscCorners = 16;

std::array<Point2, 4> corners_of(const Pose2& T_plan_box, const Point2& size_m) {
  const Point2 half = 0.5 * size_m;
  return {T_plan_box * Point2(-half.x(), -half.y()), T_plan_box * Point2(half.x(), -half.y()),
          T_plan_box * half, T_plan_box * Point2(-half.x(), half.y())};
}

double cross(const Point2& a, const Point2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Whether a point lies in a convex polygon whose corners are counter-clockwise.
bool is_inside(const Point2& point, std::span<const Point2> corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point2& from = corners[i];
    const Point2& to = corners[(i + 1) % corners.size()];
    if (cross(to - from, point - from) < 0.0) return false;
  }
  return true;
}

/// Free cells that can be reached from `start` by steps to the four sides; marks them in `seen`.
std::vector<std::size_t> free_space_from(const OccupancyGrid& grid, std::size_t start,
                                         std::vector<bool>& seen) {
  const auto width = static_cast<std::size_t>(grid.width);
  std::vector<std::size_t> reached{start};
  seen[start] = true;
  const auto visit = [&](bool exists, std::size_t cell) {
    if (!exists || seen[cell] || grid.cells[cell] != Cell::kFree) return;
    seen[cell] = true;
    reached.push_back(cell);
  };
  for (std::size_t next = 0; next < reached.size();) {
    const std::size_t cell = reached[next++];
    visit(cell % width > 0, cell - 1);
    visit(cell % width + 1 < width, cell + 1);
    visit(cell >= width, cell - width);
    visit(cell + width < grid.cells.size(), cell + width);
  }
  return reached;
}

void keep_largest_free_space(OccupancyGrid& grid) {
  std::vector<bool> seen(grid.cells.size(), false);
  std::vector<std::size_t> largest;
  for (std::size_t cell = 0; cell < grid.cells.size(); ++cell) {
    if (grid.cells[cell] != Cell::kFree || seen[cell]) continue;
    std::vector<std::size_t> space = free_space_from(grid, cell, seen);
    if (space.size() > largest.size()) largest = std::move(space);
  }
  std::ranges::replace(grid.cells, Cell::kFree, Cell::kUnknown);
  for (const std::size_t cell : largest) grid.cells[cell] = Cell::kFree;
}

}  // namespace

SceneCanvas::SceneCanvas(const Point2& size_m, double yaw, Cell background) : size_m_(size_m) {
  const auto corners = corners_of({0.0, 0.0, yaw}, size_m);
  Point2 reach = Point2::Zero();  // from the centre
  for (const Point2& corner : corners) reach = reach.cwiseMax(corner);
  reach += Point2::Constant(kMargin);
  grid_.resolution = kResolution;
  grid_.width = static_cast<int>(std::ceil(2.0 * reach.x() / kResolution));
  grid_.height = static_cast<int>(std::ceil(2.0 * reach.y() / kResolution));
  grid_.cells.assign(static_cast<std::size_t>(grid_.width) * static_cast<std::size_t>(grid_.height),
                     Cell::kUnknown);
  T_grid_plan_ =
      Pose2{reach.x(), reach.y(), yaw} * Pose2{-0.5 * size_m.x(), -0.5 * size_m.y(), 0.0};
  area({Point2::Zero(), size_m}, background);
}

void SceneCanvas::area(const PlanArea& area, Cell value) {
  polygon(corners_of({area.center().x(), area.center().y(), 0.0}, area.size()), value);
}

void SceneCanvas::box(const Pose2& T_plan_box, const Point2& size_m, Cell value) {
  polygon(corners_of(T_plan_box, size_m.cwiseMax(kThinnest)), value);
}

void SceneCanvas::wall(const Point2& from, const Point2& to, double thickness_m, Cell value) {
  const Point2 along = to - from;
  const Point2 middle = 0.5 * (from + to);
  box({middle.x(), middle.y(), std::atan2(along.y(), along.x())},
      {along.norm() + thickness_m, thickness_m}, value);
}

void SceneCanvas::disc(const Point2& center, double radius_m, Cell value) {
  const double radius = std::max(radius_m, 0.5 * kThinnest);
  std::array<Point2, kDiscCorners> corners;
  for (std::size_t i = 0; i < kDiscCorners; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / kDiscCorners;
    corners[i] = center + radius * Point2{std::cos(angle), std::sin(angle)};
  }
  polygon(corners, value);
}

void SceneCanvas::room(const PlanArea& area, double thickness_m) {
  const Point2 lower_right{area.high.x(), area.low.y()};
  const Point2 upper_left{area.low.x(), area.high.y()};
  wall(area.low, lower_right, thickness_m);
  wall(lower_right, area.high, thickness_m);
  wall(area.high, upper_left, thickness_m);
  wall(upper_left, area.low, thickness_m);
}

OccupancyGrid SceneCanvas::take() {
  keep_largest_free_space(grid_);
  return std::move(grid_);
}

void SceneCanvas::polygon(std::span<const Point2> corners_plan, Cell value) {
  std::vector<Point2> corners;
  Point2 low = Point2::Constant(std::numeric_limits<double>::infinity());
  Point2 high = -low;
  for (const Point2& corner : corners_plan) {
    corners.push_back(T_grid_plan_ * corner);
    low = low.cwiseMin(corners.back());
    high = high.cwiseMax(corners.back());
  }
  const CellIndex first = grid_.cell_of(low);
  const CellIndex last = grid_.cell_of(high);
  for (int row = std::max(0, first.row); row <= std::min(grid_.height - 1, last.row); ++row) {
    for (int column = std::max(0, first.column); column <= std::min(grid_.width - 1, last.column);
         ++column) {
      if (is_inside(grid_.center({column, row}), corners))
        grid_.cells[grid_.offset({column, row})] = value;
    }
  }
}

}  // namespace cornerfix::evaluation

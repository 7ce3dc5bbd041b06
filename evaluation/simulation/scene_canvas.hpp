/// \file  Draws a plan in metres into an occupancy grid.
#pragma once

#include <span>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>

namespace cornerfix::evaluation {

/// A rectangle along the axes of a plan. [m]
struct PlanArea {
  Point2 low = Point2::Zero();
  Point2 high = Point2::Zero();

  [[nodiscard]] Point2 center() const { return 0.5 * (low + high); }
  [[nodiscard]] Point2 size() const { return high - low; }
  /// The area without a rim of `m`.
  [[nodiscard]] PlanArea inset(double m) const {
    return {low + Point2::Constant(m), high - Point2::Constant(m)};
  }
};

/// A plan from (0, 0) to its size, turned as a whole in the grid. A cell takes a value where its
/// centre lies in what is drawn; later drawings cover earlier ones.
class SceneCanvas {
 public:
  /// \param yaw  Of the plan in the grid [rad].
  SceneCanvas(const Point2& size_m, double yaw, Cell background);

  void area(const PlanArea& area, Cell value);
  /// A turned rectangle about a pose of the plan. Nothing is drawn thinner than a wall of one cell.
  void box(const Pose2& T_plan_box, const Point2& size_m, Cell value = Cell::kOccupied);
  /// A straight wall; its ends reach half of its thickness beyond the points.
  void wall(const Point2& from, const Point2& to, double thickness_m, Cell value = Cell::kOccupied);
  void disc(const Point2& center, double radius_m, Cell value = Cell::kOccupied);
  /// The four walls about an area, their middle on its border.
  void room(const PlanArea& area, double thickness_m);

  [[nodiscard]] const Point2& size() const { return size_m_; }

  /// The grid. Free cells that the largest free space does not reach become unknown.
  [[nodiscard]] OccupancyGrid take();

 private:
  void polygon(std::span<const Point2> corners_plan, Cell value);

  Point2 size_m_;
  Pose2 T_grid_plan_;
  OccupancyGrid grid_;
};

}  // namespace cornerfix::evaluation

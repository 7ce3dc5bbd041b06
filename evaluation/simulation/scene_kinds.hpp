/// \file  One function per kind of scene, and what they share; private to the generator.
#pragma once

#include <numbers>

#include <cornerfix/occupancy_grid.hpp>

#include "evaluation/simulation/scene_canvas.hpp"
#include "evaluation/simulation/seeded_random.hpp"

namespace cornerfix::evaluation {

inline constexpr double kPi = std::numbers::pi;

/// What a kind draws from. `layout` never depends on how much is drawn from `change`.
struct SceneSeeds {
  SeededRandom layout;
  SeededRandom change;

  /// A plan of a size between two. Half of the plans lie along the axes of the grid. Every draw is
  /// a statement of its own: the order in which arguments are evaluated is not specified.
  [[nodiscard]] SceneCanvas canvas(const Point2& smallest, const Point2& largest, Cell background) {
    const double x = layout.uniform(smallest.x(), largest.x());
    const double y = layout.uniform(smallest.y(), largest.y());
    const bool is_straight = layout.chance(0.5);
    const double yaw = layout.uniform(-0.5, 0.5);
    return {{x, y}, is_straight ? 0.0 : yaw, background};
  }
};

/// Pillars, cabinets and the like along the two long sides of an area, one per `metres_each`: they
/// make one stretch of a wall differ from another.
void draw_landmarks(SceneCanvas& canvas, SeededRandom& layout, const PlanArea& area,
                    double metres_each);

[[nodiscard]] OccupancyGrid warehouse_scene(SceneSeeds& seeds);
[[nodiscard]] OccupancyGrid yard_scene(SceneSeeds& seeds);
[[nodiscard]] OccupancyGrid corridors_scene(SceneSeeds& seeds);
[[nodiscard]] OccupancyGrid office_scene(SceneSeeds& seeds);
[[nodiscard]] OccupancyGrid home_scene(SceneSeeds& seeds);
[[nodiscard]] OccupancyGrid hall_scene(SceneSeeds& seeds);
[[nodiscard]] OccupancyGrid glass_scene(SceneSeeds& seeds);

}  // namespace cornerfix::evaluation

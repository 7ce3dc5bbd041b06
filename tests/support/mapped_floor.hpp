/// \file  Maps of scenes drawn into an occupancy map, as imported ones are.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <cornerfix/localization_map.hpp>
#include <cornerfix/mapper.hpp>

#include "support/drawn_grid.hpp"

namespace cornerfix::testing {

/// Two rooms without a way between them, 20 m apart and equal to the last box.
[[nodiscard]] inline SceneBuilder equal_rooms() {
  SceneBuilder scene;
  for (const double x : {0.0, 20.0}) {
    scene.room({x, 0}, {x + 7.0, 5.0}).box({x + 5.2, 1.1}, {0.8, 1.2}, 0.3);
    scene.box({x + 1.6, 4.1}, {1.3, 0.7});
  }
  return scene;
}

/// Walls far apart, a niche that distinguishes one corner from the others.
[[nodiscard]] inline SceneBuilder bare_hall() {
  return SceneBuilder().room({0, 0}, {40, 20}).box({1.0, 19.0}, {2.0, 2.0});
}

/// The map of the free space about the points `inside`, in the plane from `low_m` on.
[[nodiscard]] inline LocalizationMapPtr mapped_floor(const SceneBuilder& scene,
                                                     const std::vector<Point2>& inside,
                                                     const Point2& size_m,
                                                     const Point2& low_m = Point2::Zero()) {
  OccupancyGrid grid =
      unknown_grid({low_m.x() - 1.0, low_m.y() - 1.0, 0.0}, size_m + Point2::Constant(2.0), 0.05);
  draw_walls(grid, scene);
  for (const Point2& point : inside) free_from(grid, point);
  return std::make_shared<const LocalizationMap>("floor", 1,
                                                 map_from_grid(grid, {}).value().content);
}

}  // namespace cornerfix::testing

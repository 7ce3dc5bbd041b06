/// \file  Floor plans that several tests drive in.
#pragma once

#include <random>

#include "support/map_maker.hpp"

namespace cornerfix::testing {

/// A room like no other: boxes and short walls at random places of an oblong, all of it seen from
/// its open middle at (0, 0).
[[nodiscard]] inline SceneBuilder random_room(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> wall(3.5, 6.0), size(0.4, 1.1), turn(-1.5, 1.5),
      share(0, 1);
  const Point2 low(-wall(random), -wall(random));
  const Point2 high(wall(random), wall(random));
  SceneBuilder scene = SceneBuilder().room(low, high);
  for (int placed = 0; placed < 7;) {
    const Point2 center = low + (high - low).cwiseProduct(Point2(share(random), share(random)));
    if (center.norm() < 1.6) continue;
    scene.box(center, {size(random), size(random)}, turn(random));
    ++placed;
  }
  return scene;
}

/// Three rooms on a corridor, none like another; start in the corridor, at (1, 1).
[[nodiscard]] inline SceneBuilder offices() {
  return SceneBuilder()
      .room({0, 0}, {16, 9})
      .wall({0, 2}, {1.5, 2})
      .wall({2.5, 2}, {6.5, 2})
      .wall({7.5, 2}, {12.5, 2})
      .wall({13.5, 2}, {16, 2})
      .wall({5, 2}, {5, 9})
      .wall({11, 2}, {11, 9})
      .box({3.8, 7.6}, {1.2, 0.8}, 0.2)
      .box({0.6, 5.0}, {0.9, 1.4})
      .box({8.2, 6.3}, {1.0, 1.0}, 0.7)
      .box({10.4, 3.0}, {0.7, 1.3})
      .wall({11, 6}, {13, 6})
      .box({15.2, 8.0}, {1.0, 1.2}, 0.1)
      .box({6.0, 0.25}, {1.0, 0.5});
}

/// From the corridor into the left and the middle room of the offices.
[[nodiscard]] inline std::vector<Pose2> drive_through_offices(double step_m = 0.4,
                                                              double turn_rad = 0.35) {
  const Point2 points[] = {{1.0, 1.0}, {2.0, 1.2}, {2.0, 4.5}, {2.0, 1.2},
                           {7.0, 1.2}, {7.0, 4.0}, {6.2, 7.0}};
  return route(points, step_m, turn_rad);
}

}  // namespace cornerfix::testing

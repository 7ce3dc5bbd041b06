/// \file  Storeys of 30 by 20 m, drawn at random: a corridor with rooms of unequal widths on both
/// sides, doors, furniture and columns. Many of them look alike to a robot that saw one room only.
#pragma once

#include <cstdint>
#include <random>
#include <utility>

#include <cornerfix/occupancy_grid.hpp>

#include "support/drawn_grid.hpp"
#include "support/scene_builder.hpp"

namespace cornerfix::testing {

inline const Point2 kStoreySize{30.0, 20.0};

struct Storey {
  SceneBuilder scene;
  Point2 inside = Point2::Zero();  ///< In the corridor.
  double corridor_low = 0.0;       ///< Its walls [m].
  double corridor_high = 0.0;

  [[nodiscard]] OccupancyGrid grid(double resolution = 0.05) const {
    return drawn_grid(scene, inside, {-0.5, -0.5, 0.0}, kStoreySize + Point2(1.0, 1.0), resolution);
  }
};

class StoreyPlanner {
 public:
  explicit StoreyPlanner(std::uint64_t seed) : random_(seed) {}

  [[nodiscard]] Storey plan() {
    storey_.corridor_low = draw(7.0, 11.0);
    storey_.corridor_high = storey_.corridor_low + draw(1.8, 3.0);
    storey_.inside = {draw(0.8, 1.5), (storey_.corridor_low + storey_.corridor_high) / 2.0};
    storey_.scene.room({0.0, 0.0}, kStoreySize);
    add_rooms(0.0, storey_.corridor_low, storey_.corridor_low);
    add_rooms(storey_.corridor_high, kStoreySize.y(), storey_.corridor_high);
    return std::move(storey_);
  }

 private:
  double draw(double low, double high) {
    // Not by a distribution: they differ between standard libraries.
    return low + (high - low) * 0x1p-53 * static_cast<double>(random_() >> 11U);
  }

  /// Rooms between two walls along x; `corridor` is the one with doors.
  void add_rooms(double low, double high, double corridor) {
    constexpr double kWidest = 8.0;
    for (double left = 0.0; left < kStoreySize.x();) {
      double right = left + draw(3.0, kWidest);
      if (right > kStoreySize.x() - 3.0) right = kStoreySize.x();
      if (right < kStoreySize.x()) storey_.scene.wall({right, low}, {right, high});
      const double width = draw(0.9, 1.3);
      const double door = draw(left + 0.3, right - 0.3 - width);
      storey_.scene.wall({left, corridor}, {door, corridor});
      storey_.scene.wall({door + width, corridor}, {right, corridor});
      furnish({left, low}, {right, high});
      left = right;
    }
  }

  /// The middle of each room stays free.
  void furnish(const Point2& low, const Point2& high) {
    const Point2 margin(0.9, 1.6);
    const int count = static_cast<int>(draw(1.0, 4.99));
    for (int i = 0; i < count; ++i) {
      const Point2 a = low + margin;
      const Point2 b = high - margin;
      if (a.x() >= b.x() || a.y() >= b.y()) return;
      const Point2 center(draw(a.x(), b.x()), draw(a.y(), b.y()));
      const double length = draw(0.4, 1.6);
      const double depth = draw(0.3, 0.8);
      storey_.scene.box(center, {length, depth}, draw(0.0, 1.0) < 0.5 ? 0.0 : draw(-1.5, 1.5));
    }
  }

  std::mt19937_64 random_;
  Storey storey_;
};

/// Same seed, same storey.
[[nodiscard]] inline Storey random_storey(std::uint64_t seed) { return StoreyPlanner(seed).plan(); }

}  // namespace cornerfix::testing

// Scenes of one large room.
#include <algorithm>

#include "evaluation/simulation/scene_kinds.hpp"

namespace cornerfix::evaluation {

namespace {

void draw_columns(SceneCanvas& canvas, SeededRandom& layout) {
  const Point2 pitch{layout.uniform(5.0, 14.0), layout.uniform(5.0, 14.0)};
  const bool is_round = layout.chance(0.5);
  const double side = layout.uniform(0.3, 1.0);
  for (double x = pitch.x(); x < canvas.size().x() - 2.0; x += pitch.x()) {
    for (double y = pitch.y(); y < canvas.size().y() - 2.0; y += pitch.y()) {
      if (is_round) {
        canvas.disc({x, y}, 0.5 * side);
      } else {
        canvas.box({x, y, 0.0}, Point2::Constant(side));
      }
    }
  }
}

void draw_stands(SceneCanvas& canvas, SeededRandom& change) {
  const int stands = change.integer(2, 16);
  for (int i = 0; i < stands; ++i) {
    const Point2 at{change.uniform(3.0, canvas.size().x() - 3.0),
                    change.uniform(3.0, canvas.size().y() - 3.0)};
    const double yaw = change.uniform(-kPi, kPi);
    const Point2 size{change.uniform(0.4, 2.0), change.uniform(0.4, 1.2)};
    canvas.box({at.x(), at.y(), yaw}, size);
  }
}

/// Walls of framed glass.
struct Glazing {
  double pane_m = 1.2;
  double blinds = 0.3;  ///< Share of the panes whose blinds are down: beams do not pass them.
  double frame_m = 0.1;

  void draw(SceneCanvas& canvas, SeededRandom& change, const Point2& from, const Point2& to) const {
    const int panes = std::max(1, static_cast<int>((to - from).norm() / pane_m));
    const Point2 step = (to - from) / panes;
    for (int i = 0; i < panes; ++i) {
      const Cell pane = change.chance(blinds) ? Cell::kOccupied : Cell::kUnknown;
      canvas.wall(from + i * step, from + (i + 1) * step, 0.1, pane);
    }
    for (int i = 0; i <= panes; ++i) {
      const Point2 at = from + i * step;
      canvas.box({at.x(), at.y(), 0.0}, Point2::Constant(frame_m));
    }
  }
};

/// Glazed rooms side by side along the lower wall.
void draw_glazed_rooms(SceneCanvas& canvas, SceneSeeds& seeds, const Glazing& glazing,
                       double wall_m, double depth_m) {
  SeededRandom& layout = seeds.layout;
  for (double x = wall_m; x + 3.0 < canvas.size().x();) {
    const double width = std::min(layout.uniform(3.0, 6.0), canvas.size().x() - wall_m - x);
    const bool is_glazed = layout.chance(0.8);
    if (is_glazed) {
      glazing.draw(canvas, seeds.change, {x, depth_m}, {x + width, depth_m});
      glazing.draw(canvas, seeds.change, {x + width, wall_m}, {x + width, depth_m});
      const double door = x + width * layout.uniform(0.3, 0.7);
      canvas.box({door, depth_m, 0.0}, {0.95, 0.3}, Cell::kFree);
    }
    x += width;
  }
}

}  // namespace

OccupancyGrid hall_scene(SceneSeeds& seeds) {
  SeededRandom& layout = seeds.layout;
  SceneCanvas canvas = seeds.canvas({40.0, 28.0}, {100.0, 70.0}, Cell::kFree);
  const double wall_m = layout.uniform(0.2, 0.6);
  const PlanArea hall = PlanArea{Point2::Zero(), canvas.size()}.inset(0.5 * wall_m);
  canvas.room(hall, wall_m);
  draw_columns(canvas, layout);
  const double metres_each = layout.uniform(8.0, 25.0);
  draw_landmarks(canvas, layout, hall.inset(0.5 * wall_m), metres_each);
  draw_stands(canvas, seeds.change);
  return canvas.take();
}

OccupancyGrid glass_scene(SceneSeeds& seeds) {
  SeededRandom& layout = seeds.layout;
  SceneCanvas canvas = seeds.canvas({22.0, 16.0}, {45.0, 30.0}, Cell::kFree);
  const double wall_m = layout.uniform(0.15, 0.4);
  canvas.room(PlanArea{Point2::Zero(), canvas.size()}.inset(0.5 * wall_m), wall_m);
  Glazing glazing;
  glazing.pane_m = layout.uniform(0.9, 1.6);
  glazing.blinds = layout.uniform(0.1, 0.5);
  glazing.frame_m = layout.uniform(0.08, 0.14);
  const double depth_m = layout.uniform(4.0, 6.0);
  draw_glazed_rooms(canvas, seeds, glazing, wall_m, depth_m);
  const PlanArea open{{wall_m, depth_m + 3.0}, canvas.size() - Point2::Constant(wall_m)};
  draw_landmarks(canvas, layout, open, 8.0);
  return canvas.take();
}

}  // namespace cornerfix::evaluation

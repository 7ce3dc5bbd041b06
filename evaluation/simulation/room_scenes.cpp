// Scenes of equal rooms along corridors.
#include <algorithm>

#include "evaluation/simulation/scene_kinds.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr double kDoorWidth = 0.95;   // [m]
constexpr double kClearOfDoor = 0.9;  // [m] without furniture, so that a robot gets through

/// A row of equal rooms along a corridor.
struct RoomRow {
  Point2 from = Point2::Zero();  ///< Where the wall of the corridor begins.
  bool along_x = true;
  double side = 1.0;  ///< The rooms lie at higher coordinates, or (-1) at lower ones.
  double length_m = 30.0;
  double room_m = 3.5;  ///< Along the corridor.
  double depth_m = 5.0;
  double wall_m = 0.12;
};

/// What all rooms of a building share.
struct RoomStyle {
  double door_at = 0.5;   ///< Along the wall of the room, 0 to 1.
  double niche_m = 0.15;  ///< How deep the door leaf lies behind the wall of the corridor.
  double open = 0.5;      ///< Share of the doors that stand open.
  double desks = 0.0;     ///< Share of the rooms with a desk at the usual place.
  double loose = 0.0;     ///< Loose pieces per room.
};

RoomStyle room_style(SeededRandom& layout) {
  RoomStyle style;
  style.door_at = layout.uniform(0.3, 0.7);
  style.niche_m = layout.uniform(0.0, 0.3);
  style.open = layout.uniform(0.2, 0.8);
  return style;
}

/// Draws rows of rooms.
class RoomDrawer {
 public:
  RoomDrawer(SceneCanvas& canvas, SceneSeeds& seeds, const RoomStyle& style)
      : canvas_(canvas), seeds_(seeds), style_(style) {}

  void draw(const RoomRow& row) {
    canvas_.area(area(row, 0.0, 0.0, row.length_m, row.depth_m), Cell::kFree);
    const int rooms = std::max(1, static_cast<int>(row.length_m / row.room_m));
    const double room_m = row.length_m / rooms;
    wall(row, 0.0, 0.0, row.length_m, 0.0);
    wall(row, 0.0, row.depth_m, row.length_m, row.depth_m);
    for (int i = 0; i <= rooms; ++i) wall(row, i * room_m, 0.0, i * room_m, row.depth_m);
    for (int i = 0; i < rooms; ++i) {
      draw_door(row, (i + style_.door_at) * room_m);
      furnish(row, i * room_m, room_m);
    }
  }

 private:
  /// A point `u` along the wall of the corridor and `v` into the rooms.
  static Point2 point(const RoomRow& row, double u, double v) {
    return row.along_x ? Point2{row.from.x() + u, row.from.y() + row.side * v}
                       : Point2{row.from.x() + row.side * v, row.from.y() + u};
  }

  static PlanArea area(const RoomRow& row, double u0, double v0, double u1, double v1) {
    const Point2 a = point(row, u0, v0);
    const Point2 b = point(row, u1, v1);
    return {a.cwiseMin(b), a.cwiseMax(b)};
  }

  void wall(const RoomRow& row, double u0, double v0, double u1, double v1) {
    canvas_.wall(point(row, u0, v0), point(row, u1, v1), row.wall_m);
  }

  /// A gap in the wall of the corridor, and in it a leaf when the door is closed.
  void draw_door(const RoomRow& row, double u) {
    const bool is_open = seeds_.change.chance(style_.open);
    const double half = 0.5 * kDoorWidth;
    canvas_.area(area(row, u - half, -0.6 * row.wall_m, u + half, 0.6 * row.wall_m), Cell::kFree);
    if (is_open) {
      wall_of(point(row, u + half, 0.0), point(row, u + half, kDoorWidth));
    } else {
      wall_of(point(row, u - half, style_.niche_m), point(row, u + half, style_.niche_m));
      wall_of(point(row, u - half, 0.0), point(row, u - half, style_.niche_m));
      wall_of(point(row, u + half, 0.0), point(row, u + half, style_.niche_m));
    }
  }

  void wall_of(const Point2& from, const Point2& to) { canvas_.wall(from, to, 0.075); }

  /// A desk at the same place in every room that has one, and loose pieces anywhere but at the
  /// door.
  void furnish(const RoomRow& row, double u0, double room_m) {
    const bool has_desk = seeds_.layout.chance(style_.desks);
    if (has_desk) {
      canvas_.area(area(row, u0 + 0.3, row.depth_m - 1.0, u0 + std::min(1.9, 0.5 * room_m),
                        row.depth_m - 0.2),
                   Cell::kOccupied);
    }
    const int pieces = seeds_.change.integer(0, static_cast<int>(2.0 * style_.loose));
    for (int i = 0; i < pieces; ++i) {
      const double u = u0 + seeds_.change.uniform(0.5, room_m - 0.5);
      const double v = seeds_.change.uniform(kClearOfDoor + 0.4, row.depth_m - 0.4);
      const double yaw = seeds_.change.uniform(-kPi, kPi);
      const double size = seeds_.change.uniform(0.3, 0.6);
      const Point2 at = point(row, u, v);
      canvas_.box({at.x(), at.y(), yaw}, Point2::Constant(size));
    }
  }

  SceneCanvas& canvas_;
  SceneSeeds& seeds_;
  RoomStyle style_;
};

/// Carts, bins and chairs beside the walls of a corridor.
void draw_loose_things(SceneCanvas& canvas, SeededRandom& change, const PlanArea& area, int most) {
  const int count = change.integer(0, most);
  for (int i = 0; i < count; ++i) {
    const bool at_low_side = change.chance(0.5);
    const double size = change.uniform(0.2, 0.5);
    const Point2 at{change.uniform(area.low.x(), area.high.x()),
                    at_low_side ? area.low.y() + 0.5 * size : area.high.y() - 0.5 * size};
    const double yaw = change.uniform(-0.2, 0.2);
    canvas.box({at.x(), at.y(), yaw}, Point2::Constant(size));
  }
}

/// Sizes that all corridors of a building share.
struct CorridorPlan {
  double wall_m = 0.2;
  double depth_m = 5.0;     ///< Of the rooms.
  double corridor_m = 2.4;  ///< Width.
  double room_m = 4.0;      ///< Along the corridor.
  double cross_m = 2.5;     ///< Width of the corridors at both ends, which join the others.

  /// Distance of one corridor from the next.
  [[nodiscard]] double pitch_m() const { return corridor_m + 2.0 * depth_m + wall_m; }
};

/// The corridors at both ends, with walls about all.
void draw_ends(SceneCanvas& canvas, const CorridorPlan& plan) {
  const PlanArea all{{plan.wall_m, plan.depth_m},
                     {canvas.size().x() - plan.wall_m, canvas.size().y() - plan.depth_m}};
  canvas.area({all.low, {all.low.x() + plan.cross_m, all.high.y()}}, Cell::kFree);
  canvas.area({{all.high.x() - plan.cross_m, all.low.y()}, all.high}, Cell::kFree);
  canvas.room(all, plan.wall_m);
}

/// A corridor from end to end, with rooms on both sides.
void draw_corridor(SceneCanvas& canvas, SceneSeeds& seeds, RoomDrawer& rooms,
                   const CorridorPlan& plan, double low) {
  const double left = plan.cross_m + plan.wall_m;
  const double length_m = canvas.size().x() - 2.0 * left;
  const double depth = plan.depth_m - plan.wall_m;
  const PlanArea corridor{{left, low}, {left + length_m, low + plan.corridor_m}};
  canvas.area({{plan.wall_m, low}, {canvas.size().x() - plan.wall_m, low + plan.corridor_m}},
              Cell::kFree);
  rooms.draw({corridor.low, true, -1.0, length_m, plan.room_m, depth, plan.wall_m});
  rooms.draw({{left, corridor.high.y()}, true, 1.0, length_m, plan.room_m, depth, plan.wall_m});
  const PlanArea between = corridor.inset(0.5 * plan.wall_m);
  draw_landmarks(canvas, seeds.layout, between, 25.0);
  draw_loose_things(canvas, seeds.change, between, 6);
}

/// The outer walls at both ends, where the corridors have cut them open.
void close_ends(SceneCanvas& canvas, const CorridorPlan& plan) {
  for (const double x : {plan.wall_m, canvas.size().x() - plan.wall_m})
    canvas.wall({x, plan.depth_m}, {x, canvas.size().y() - plan.depth_m}, plan.wall_m);
}

/// Rooms on both sides of a corridor that runs around a core.
void draw_ring(SceneCanvas& canvas, RoomDrawer& rooms, const PlanArea& inner, const PlanArea& core,
               const CorridorPlan& plan) {
  const double depth = plan.depth_m - plan.wall_m;
  const double core_depth = std::min(depth, 0.5 * core.size().y());
  const auto row = [&](const Point2& from, bool along_x, double side, double length_m,
                       double depth_m) {
    rooms.draw({from, along_x, side, length_m, plan.room_m, depth_m, plan.wall_m});
  };
  row(inner.low, true, -1.0, inner.size().x(), depth);
  row({inner.low.x(), inner.high.y()}, true, 1.0, inner.size().x(), depth);
  row(inner.low, false, -1.0, inner.size().y(), depth);
  row({inner.high.x(), inner.low.y()}, false, 1.0, inner.size().y(), depth);
  row(core.low, true, 1.0, core.size().x(), core_depth);
  row({core.low.x(), core.high.y()}, true, -1.0, core.size().x(), core_depth);
  canvas.wall(core.low, {core.low.x(), core.high.y()}, plan.wall_m);
  canvas.wall({core.high.x(), core.low.y()}, core.high, plan.wall_m);
}

}  // namespace

OccupancyGrid corridors_scene(SceneSeeds& seeds) {
  SeededRandom& layout = seeds.layout;
  CorridorPlan plan;
  plan.wall_m = layout.uniform(0.1, 0.3);
  plan.depth_m = layout.uniform(3.5, 6.0);
  plan.corridor_m = layout.uniform(1.8, 3.2);
  plan.room_m = layout.uniform(2.6, 5.5);
  const int corridors = layout.integer(1, 3);
  const Point2 least{50.0, corridors * plan.pitch_m()};
  SceneCanvas canvas = seeds.canvas(least, {110.0, least.y()}, Cell::kUnknown);
  RoomStyle style = room_style(layout);
  style.loose = layout.uniform(0.0, 1.0);
  plan.cross_m = layout.uniform(2.0, 3.0);
  RoomDrawer rooms(canvas, seeds, style);
  draw_ends(canvas, plan);
  for (int i = 0; i < corridors; ++i)
    draw_corridor(canvas, seeds, rooms, plan, i * plan.pitch_m() + plan.depth_m);
  close_ends(canvas, plan);
  return canvas.take();
}

OccupancyGrid office_scene(SceneSeeds& seeds) {
  SeededRandom& layout = seeds.layout;
  CorridorPlan plan;
  plan.wall_m = layout.uniform(0.08, 0.2);
  plan.depth_m = layout.uniform(3.5, 5.5);
  plan.corridor_m = layout.uniform(1.6, 2.6);
  plan.room_m = layout.uniform(2.8, 4.5);
  const double ring = plan.depth_m + plan.corridor_m;
  SceneCanvas canvas = seeds.canvas({2.0 * ring + 10.0, 2.0 * ring + 2.5 * plan.depth_m},
                                    {60.0, 40.0}, Cell::kUnknown);
  RoomStyle style = room_style(layout);
  style.desks = layout.uniform(0.6, 1.0);
  style.loose = layout.uniform(0.5, 1.5);
  RoomDrawer rooms(canvas, seeds, style);
  const PlanArea inner = PlanArea{Point2::Zero(), canvas.size()}.inset(plan.depth_m);
  const PlanArea core = inner.inset(plan.corridor_m);
  canvas.area(inner, Cell::kFree);
  canvas.area(core, Cell::kUnknown);
  draw_ring(canvas, rooms, inner, core, plan);
  const PlanArea lower{inner.low + Point2::Constant(0.5 * plan.wall_m),
                       {inner.high.x(), inner.low.y() + plan.corridor_m}};
  draw_landmarks(canvas, layout, lower, 30.0);
  return canvas.take();
}

}  // namespace cornerfix::evaluation

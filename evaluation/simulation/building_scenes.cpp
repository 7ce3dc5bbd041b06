// Scenes of rooms and corridors.
#include <algorithm>
#include <numbers>
#include <vector>

#include "evaluation/simulation/scene_kinds.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr double kPi = std::numbers::pi;
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

/// Pillars, cabinets and the like, which make one stretch of a corridor differ from another.
void draw_landmarks(SceneCanvas& canvas, SeededRandom& layout, const PlanArea& area,
                    double metres_each) {
  const int count = static_cast<int>(area.size().x() / metres_each);
  for (int i = 0; i < count; ++i) {
    const bool at_low_side = layout.chance(0.5);
    const Point2 size{layout.uniform(0.2, 1.2), layout.uniform(0.15, 0.4)};
    const Point2 at{layout.uniform(area.low.x() + 1.0, area.high.x() - 1.0),
                    at_low_side ? area.low.y() + 0.5 * size.y() : area.high.y() - 0.5 * size.y()};
    canvas.box({at.x(), at.y(), 0.0}, size);
  }
}

/// Divides a flat into rooms until they are small, with a door in each wall between two.
class Flat {
 public:
  explicit Flat(SceneSeeds seeds)
      : seeds_(std::move(seeds)),
        canvas_(seeds_.canvas({8.0, 7.0}, {16.0, 12.0}, Cell::kFree)),
        wall_m_(seeds_.layout.uniform(0.08, 0.25)),
        room_m_(seeds_.layout.uniform(3.2, 5.0)) {}

  OccupancyGrid draw() {
    const double outer_m = seeds_.layout.uniform(0.2, 0.4);
    const PlanArea flat = PlanArea{Point2::Zero(), canvas_.size()}.inset(0.5 * outer_m);
    canvas_.room(flat, outer_m);
    divide(flat);
    for (const PlanArea& room : rooms_) furnish(room);
    for (const Door& door : doors_) open(door);
    return canvas_.take();
  }

 private:
  struct Door {
    Point2 center;
    double width = 0.9;
  };

  void divide(const PlanArea& area) {
    const Point2 size = area.size();
    if (size.maxCoeff() < room_m_ || size.minCoeff() < 2.2) {
      rooms_.push_back(area);
      return;
    }
    const Eigen::Index axis = size.x() > size.y() ? 0 : 1;
    const double at = area.low[axis] + seeds_.layout.uniform(0.38, 0.62) * size[axis];
    PlanArea first = area;
    PlanArea second = area;
    first.high[axis] = at;
    second.low[axis] = at;
    canvas_.wall(second.low, first.high, wall_m_);
    const double share = seeds_.layout.uniform(0.2, 0.8);
    const double width = seeds_.layout.uniform(0.8, 1.1);
    Point2 door = second.low + share * (first.high - second.low);
    // Off the ends of the wall, where another wall may begin.
    const Eigen::Index other = 1 - axis;
    door[other] = std::clamp(door[other], area.low[other] + 0.9, area.high[other] - 0.9);
    doors_.push_back({door, width});
    divide(first);
    divide(second);
  }

  /// Fixed things along the walls by the layout, others by the change seed.
  void furnish(const PlanArea& room) {
    const int fixed = seeds_.layout.integer(0, 2);
    for (int i = 0; i < fixed; ++i) put_at_wall(seeds_.layout, room, {1.8, 0.6});
    const int loose = seeds_.change.integer(1, 3);
    for (int i = 0; i < loose; ++i) put_at_wall(seeds_.change, room, {1.4, 0.9});
    const int legs = seeds_.change.integer(0, 2);
    for (int i = 0; i < legs; ++i) put_table(room);
  }

  void put_at_wall(SeededRandom& random, const PlanArea& room, const Point2& largest) {
    const double length = random.uniform(0.4, largest.x());
    const double depth = random.uniform(0.3, largest.y());
    const int side = random.integer(0, 3);
    const double share = random.uniform(0.0, 1.0);
    const PlanArea clear = room.inset(0.5 * wall_m_);
    const Point2 size = side % 2 == 0 ? Point2{length, depth} : Point2{depth, length};
    const Point2 room_left = (clear.size() - size).cwiseMax(0.0);
    const Point2 low{clear.low.x() + (side == 0 || side == 2 ? share
                                      : side == 1            ? 0.0
                                                             : 1.0) *
                                         room_left.x(),
                     clear.low.y() + (side == 1 || side == 3 ? share
                                      : side == 0            ? 0.0
                                                             : 1.0) *
                                         room_left.y()};
    put({low, low + size});
  }

  void put_table(const PlanArea& room) {
    SeededRandom& change = seeds_.change;
    const PlanArea middle = room.inset(0.9);
    const Point2 at{change.uniform(middle.low.x(), middle.high.x()),
                    change.uniform(middle.low.y(), middle.high.y())};
    const double spread = change.uniform(0.25, 0.5);
    const double yaw = change.uniform(-kPi, kPi);
    if (middle.size().minCoeff() < 0.0) return;
    for (const double u : {-spread, spread}) {
      for (const double v : {-spread, spread}) {
        const Point2 leg = Pose2{at.x(), at.y(), yaw} * Point2(u, v);
        put({leg - Point2::Constant(0.04), leg + Point2::Constant(0.04)});
      }
    }
  }

  /// Not in front of a door.
  void put(const PlanArea& area) {
    const bool blocks = std::ranges::any_of(doors_, [&](const Door& door) {
      const Point2 nearest = door.center.cwiseMax(area.low).cwiseMin(area.high);
      return (nearest - door.center).norm() < kClearOfDoor;
    });
    if (!blocks) canvas_.area(area, Cell::kOccupied);
  }

  void open(const Door& door) {
    canvas_.box({door.center.x(), door.center.y(), 0.0}, Point2::Constant(door.width), Cell::kFree);
  }

  SceneSeeds seeds_;
  SceneCanvas canvas_;
  double wall_m_;
  double room_m_;
  std::vector<PlanArea> rooms_;
  std::vector<Door> doors_;
};

}  // namespace

OccupancyGrid corridors_scene(SceneSeeds seeds) {
  SeededRandom& layout = seeds.layout;
  const double wall_m = layout.uniform(0.1, 0.3);
  const double depth_m = layout.uniform(3.5, 6.0);
  const double corridor_m = layout.uniform(1.8, 3.2);
  const double room_m = layout.uniform(2.6, 5.5);
  const int corridors = layout.integer(1, 3);
  const double pitch_m = corridor_m + 2.0 * depth_m + wall_m;
  const Point2 least{50.0, corridors * pitch_m};
  SceneCanvas canvas = seeds.canvas(least, {110.0, least.y()}, Cell::kUnknown);
  RoomStyle style = room_style(layout);
  style.loose = layout.uniform(0.0, 1.0);
  const double cross_m = layout.uniform(2.0, 3.0);
  const double length_m = canvas.size().x() - 2.0 * cross_m - 2.0 * wall_m;
  const double left = cross_m + wall_m;
  RoomDrawer rooms(canvas, seeds, style);
  // One corridor after the other, joined at both ends.
  canvas.area({{wall_m, depth_m}, {cross_m + wall_m, canvas.size().y() - depth_m}}, Cell::kFree);
  canvas.area({{canvas.size().x() - cross_m - wall_m, depth_m},
               {canvas.size().x() - wall_m, canvas.size().y() - depth_m}},
              Cell::kFree);
  canvas.room({{wall_m, depth_m}, {canvas.size().x() - wall_m, canvas.size().y() - depth_m}},
              wall_m);
  for (int i = 0; i < corridors; ++i) {
    const double low = i * pitch_m + depth_m;
    const PlanArea corridor{{left, low}, {left + length_m, low + corridor_m}};
    canvas.area({{wall_m, low}, {canvas.size().x() - wall_m, low + corridor_m}}, Cell::kFree);
    rooms.draw({corridor.low, true, -1.0, length_m, room_m, depth_m - wall_m, wall_m});
    rooms.draw({{left, low + corridor_m}, true, 1.0, length_m, room_m, depth_m - wall_m, wall_m});
    draw_landmarks(canvas, layout, corridor.inset(0.5 * wall_m), 25.0);
    draw_loose_things(canvas, seeds.change, corridor.inset(0.5 * wall_m), 6);
  }
  canvas.wall({wall_m, depth_m}, {wall_m, canvas.size().y() - depth_m}, wall_m);
  canvas.wall({canvas.size().x() - wall_m, depth_m},
              {canvas.size().x() - wall_m, canvas.size().y() - depth_m}, wall_m);
  return canvas.take();
}

OccupancyGrid office_scene(SceneSeeds seeds) {
  SeededRandom& layout = seeds.layout;
  const double wall_m = layout.uniform(0.08, 0.2);
  const double depth_m = layout.uniform(3.5, 5.5);
  const double corridor_m = layout.uniform(1.6, 2.6);
  const double room_m = layout.uniform(2.8, 4.5);
  const double ring = depth_m + corridor_m;
  SceneCanvas canvas =
      seeds.canvas({2.0 * ring + 10.0, 2.0 * ring + 2.5 * depth_m}, {60.0, 40.0}, Cell::kUnknown);
  const Point2& size = canvas.size();
  RoomStyle style = room_style(layout);
  style.desks = layout.uniform(0.6, 1.0);
  style.loose = layout.uniform(0.5, 1.5);
  RoomDrawer rooms(canvas, seeds, style);
  const PlanArea inner{{depth_m, depth_m}, size - Point2::Constant(depth_m)};
  canvas.area(inner, Cell::kFree);
  const PlanArea core = inner.inset(corridor_m);
  canvas.area(core, Cell::kUnknown);
  const double depth = depth_m - wall_m;
  rooms.draw({inner.low, true, -1.0, inner.size().x(), room_m, depth, wall_m});
  rooms.draw({{inner.low.x(), inner.high.y()}, true, 1.0, inner.size().x(), room_m, depth, wall_m});
  rooms.draw({inner.low, false, -1.0, inner.size().y(), room_m, depth, wall_m});
  rooms.draw(
      {{inner.high.x(), inner.low.y()}, false, 1.0, inner.size().y(), room_m, depth, wall_m});
  const double core_depth = std::min(depth, 0.5 * core.size().y());
  rooms.draw({core.low, true, 1.0, core.size().x(), room_m, core_depth, wall_m});
  rooms.draw(
      {{core.low.x(), core.high.y()}, true, -1.0, core.size().x(), room_m, core_depth, wall_m});
  canvas.wall(core.low, {core.low.x(), core.high.y()}, wall_m);
  canvas.wall({core.high.x(), core.low.y()}, core.high, wall_m);
  draw_landmarks(
      canvas, layout,
      {inner.low + Point2::Constant(0.5 * wall_m), {inner.high.x(), inner.low.y() + corridor_m}},
      30.0);
  return canvas.take();
}

OccupancyGrid home_scene(SceneSeeds seeds) { return Flat(std::move(seeds)).draw(); }

OccupancyGrid hall_scene(SceneSeeds seeds) {
  SeededRandom& layout = seeds.layout;
  SceneCanvas canvas = seeds.canvas({40.0, 28.0}, {100.0, 70.0}, Cell::kFree);
  const double wall_m = layout.uniform(0.2, 0.6);
  const PlanArea hall = PlanArea{Point2::Zero(), canvas.size()}.inset(0.5 * wall_m);
  canvas.room(hall, wall_m);
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
  const PlanArea inside = hall.inset(0.5 * wall_m);
  draw_landmarks(canvas, layout, inside, layout.uniform(8.0, 25.0));
  const int stands = seeds.change.integer(2, 16);
  for (int i = 0; i < stands; ++i) {
    const Point2 at{seeds.change.uniform(3.0, canvas.size().x() - 3.0),
                    seeds.change.uniform(3.0, canvas.size().y() - 3.0)};
    const double yaw = seeds.change.uniform(-kPi, kPi);
    const Point2 size{seeds.change.uniform(0.4, 2.0), seeds.change.uniform(0.4, 1.2)};
    canvas.box({at.x(), at.y(), yaw}, size);
  }
  return canvas.take();
}

OccupancyGrid glass_scene(SceneSeeds seeds) {
  SeededRandom& layout = seeds.layout;
  SceneCanvas canvas = seeds.canvas({22.0, 16.0}, {45.0, 30.0}, Cell::kFree);
  const double wall_m = layout.uniform(0.15, 0.4);
  canvas.room(PlanArea{Point2::Zero(), canvas.size()}.inset(0.5 * wall_m), wall_m);
  const double pane_m = layout.uniform(0.9, 1.6);
  const double blinds = layout.uniform(0.1, 0.5);
  const double frame_m = layout.uniform(0.08, 0.14);
  const auto draw_panes = [&](const Point2& from, const Point2& to) {
    const int panes = std::max(1, static_cast<int>((to - from).norm() / pane_m));
    const Point2 step = (to - from) / panes;
    for (int i = 0; i < panes; ++i) {
      const Cell pane = seeds.change.chance(blinds) ? Cell::kOccupied : Cell::kUnknown;
      canvas.wall(from + i * step, from + (i + 1) * step, 0.1, pane);
    }
    for (int i = 0; i <= panes; ++i) {
      const Point2 at = from + i * step;
      canvas.box({at.x(), at.y(), 0.0}, Point2::Constant(frame_m));
    }
  };
  const double depth_m = layout.uniform(4.0, 6.0);
  for (double x = wall_m; x + 3.0 < canvas.size().x();) {
    const double width = std::min(layout.uniform(3.0, 6.0), canvas.size().x() - wall_m - x);
    const bool is_glazed = layout.chance(0.8);
    if (is_glazed) {
      draw_panes({x, depth_m}, {x + width, depth_m});
      draw_panes({x + width, wall_m}, {x + width, depth_m});
      const double door = x + width * layout.uniform(0.3, 0.7);
      canvas.box({door, depth_m, 0.0}, {kDoorWidth, 0.3}, Cell::kFree);
    }
    x += width;
  }
  draw_landmarks(canvas, layout,
                 {{wall_m, depth_m + 3.0}, canvas.size() - Point2::Constant(wall_m)}, 8.0);
  return canvas.take();
}

}  // namespace cornerfix::evaluation

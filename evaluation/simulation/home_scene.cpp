#include <algorithm>
#include <vector>

#include "evaluation/simulation/scene_kinds.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr double kDoorClearance = 0.9;  // [m] without furniture, so that a robot gets through

/// Divides a flat into rooms until they are small, with a door in each wall between two.
class Flat {
 public:
  explicit Flat(SceneSeeds& seeds)
      : seeds_(seeds),
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
      return (nearest - door.center).norm() < kDoorClearance;
    });
    if (!blocks) canvas_.area(area, Cell::kOccupied);
  }

  void open(const Door& door) {
    canvas_.box({door.center.x(), door.center.y(), 0.0}, Point2::Constant(door.width), Cell::kFree);
  }

  SceneSeeds& seeds_;
  SceneCanvas canvas_;
  double wall_m_;
  double room_m_;
  std::vector<PlanArea> rooms_;
  std::vector<Door> doors_;
};

}  // namespace

OccupancyGrid home_scene(SceneSeeds& seeds) { return Flat(seeds).draw(); }

}  // namespace cornerfix::evaluation

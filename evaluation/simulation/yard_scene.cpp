#include <algorithm>
#include <cmath>
#include <vector>

#include "evaluation/simulation/scene_kinds.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr double kRim = 4.0;  // [m] along the border without anything

class Yard {
 public:
  explicit Yard(SceneSeeds& seeds)
      : seeds_(seeds), canvas_(seeds_.canvas({110.0, 90.0}, {200.0, 150.0}, Cell::kFree)) {}

  OccupancyGrid draw() {
    draw_buildings();
    draw_trees();
    draw_fences();
    draw_parking();
    return canvas_.take();
  }

 private:
  struct Round {
    Point2 center;
    double radius = 0.0;
  };

  [[nodiscard]] bool is_within(const Point2& point, double rim_m) const {
    const Point2 to_border = point.cwiseMin(canvas_.size() - point);
    return to_border.minCoeff() > rim_m;
  }

  [[nodiscard]] bool is_clear(const Point2& point, double distance_m) const {
    return is_within(point, kRim) && std::ranges::none_of(buildings_, [&](const Round& building) {
             return (building.center - point).norm() < building.radius + distance_m;
           });
  }

  Point2 any_point(SeededRandom& random) const {
    const double x = random.uniform(kRim, canvas_.size().x() - kRim);
    return {x, random.uniform(kRim, canvas_.size().y() - kRim)};
  }

  void draw_buildings() {
    SeededRandom& layout = seeds_.layout;
    const int count = layout.integer(4, 9);
    for (int i = 0; i < count; ++i) {
      for (int tries = 0; tries < 40; ++tries) {
        const Point2 size{layout.uniform(10.0, 45.0), layout.uniform(8.0, 25.0)};
        const Point2 at = any_point(layout);
        const double radius = 0.5 * size.norm();
        if (!is_clear(at, radius + 5.0) || !is_within(at, radius + 2.0)) continue;
        const double yaw = layout.chance(0.4) ? 0.0 : layout.uniform(-0.5 * kPi, 0.5 * kPi);
        draw_building({at.x(), at.y(), yaw}, size);
        buildings_.push_back({at, radius});
        break;
      }
    }
  }

  /// One wing or two, with recessed windows and doors along the long sides.
  void draw_building(const Pose2& T_plan_building, const Point2& size) {
    SeededRandom& layout = seeds_.layout;
    canvas_.box(T_plan_building, size);
    if (layout.chance(0.4)) {  // an L: a part of the box is taken away again
      const Point2 part = size * layout.uniform(0.3, 0.6);
      canvas_.box(
          T_plan_building * Pose2{0.5 * (size.x() - part.x()), 0.5 * (size.y() - part.y()), 0.0},
          part + Point2::Constant(0.1), Cell::kFree);
    }
    const double pitch = layout.uniform(2.5, 6.0);
    const double width = layout.uniform(0.9, 1.8);
    const double depth = layout.uniform(0.15, 0.4);
    for (double u = -0.5 * size.x() + 2.0; u < 0.5 * size.x() - 2.0; u += pitch) {
      for (const double side : {-1.0, 1.0})
        canvas_.box(T_plan_building * Pose2{u, side * 0.5 * size.y(), 0.0}, {width, 2.0 * depth},
                    Cell::kFree);
    }
  }

  void draw_trees() {
    SeededRandom& layout = seeds_.layout;
    const double area_per_tree = layout.uniform(150.0, 600.0);
    const int count = static_cast<int>(canvas_.size().x() * canvas_.size().y() / area_per_tree);
    for (int i = 0; i < count; ++i) {
      const Point2 at = any_point(layout);
      const double radius = layout.uniform(0.06, 0.4);
      if (is_clear(at, 0.5)) canvas_.disc(at, radius);
    }
    if (layout.chance(0.6)) draw_avenue();
  }

  /// Lamps or trees in a row, at equal distances.
  void draw_avenue() {
    SeededRandom& layout = seeds_.layout;
    const Point2 from = any_point(layout);
    const double yaw = layout.uniform(-kPi, kPi);
    const double pitch = layout.uniform(5.0, 15.0);
    const double radius = layout.uniform(0.06, 0.3);
    for (int i = 0; i < 12; ++i) {
      const Point2 at = from + i * pitch * Point2{std::cos(yaw), std::sin(yaw)};
      if (is_clear(at, 0.5)) canvas_.disc(at, radius);
    }
  }

  void draw_fences() {
    SeededRandom& layout = seeds_.layout;
    const int count = layout.integer(2, 7);
    for (int i = 0; i < count; ++i) {
      const Point2 from = any_point(layout);
      const double yaw = layout.uniform(0.0, kPi);
      const double length = layout.uniform(8.0, 40.0);
      const double pitch = layout.chance(0.5) ? 0.1 : layout.uniform(1.0, 2.5);  // hedge or posts
      for (double along = 0.0; along < length; along += pitch) {
        const Point2 at = from + along * Point2{std::cos(yaw), std::sin(yaw)};
        if (is_clear(at, 1.5)) canvas_.disc(at, 0.08);
      }
    }
  }

  void draw_parking() {
    SeededRandom& layout = seeds_.layout;
    const int rows = layout.integer(3, 8);
    for (int row = 0; row < rows; ++row) {
      const Point2 at = any_point(layout);
      const Pose2 T_plan_row{at.x(), at.y(), layout.chance(0.5) ? 0.0 : layout.uniform(-kPi, kPi)};
      const double slant = layout.chance(0.7) ? 0.0 : layout.uniform(-0.6, 0.6);
      const double taken = layout.uniform(0.3, 0.9);
      for (int bay = 0; bay < 10; ++bay) draw_bay(T_plan_row * Pose2{2.6 * bay, 0.0, slant}, taken);
    }
  }

  /// A car or an empty bay.
  void draw_bay(const Pose2& T_plan_bay, double taken) {
    SeededRandom& change = seeds_.change;
    const bool is_taken = change.chance(taken);
    const Point2 size{change.uniform(1.6, 2.0), change.uniform(3.6, 5.2)};
    const Pose2 parked{change.uniform(-0.2, 0.2), change.uniform(-0.4, 0.4),
                       change.uniform(-0.06, 0.06)};
    if (!is_taken || !is_clear(T_plan_bay.translation(), 3.5)) return;
    canvas_.box(T_plan_bay * parked, size);
  }

  SceneSeeds& seeds_;
  SceneCanvas canvas_;
  std::vector<Round> buildings_;
};

}  // namespace

OccupancyGrid yard_scene(SceneSeeds& seeds) { return Yard(seeds).draw(); }

}  // namespace cornerfix::evaluation

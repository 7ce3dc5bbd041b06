/// \file  Floor plans made of straight walls, seen exactly: no grid, no rounding.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

namespace cornerfix::testing {

struct Wall {
  Point2 a = Point2::Zero();  ///< [m]
  Point2 b = Point2::Zero();  ///< [m]
};

[[nodiscard]] inline double cross(const Point2& a, const Point2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Walls in the frame `map`. Grows by chained calls:
/// `SceneBuilder().room({0, 0}, {10, 10}).box({3, 4}, {1, 2}, 0.3)`.
class SceneBuilder {
 public:
  SceneBuilder& wall(const Point2& a, const Point2& b) {
    walls_.push_back({a, b});
    return *this;
  }

  SceneBuilder& polygon(std::span<const Point2> points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      wall(points[i], points[(i + 1) % points.size()]);
    }
    return *this;
  }

  /// An axis-parallel rectangle between two opposite corners.
  SceneBuilder& room(const Point2& low, const Point2& high) {
    const Point2 points[] = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
    return polygon(points);
  }

  /// A rectangle of `size` turned by `yaw` about its centre.
  SceneBuilder& box(const Point2& center, const Point2& size, double yaw = 0.0) {
    const Pose2 T_map_box{center.x(), center.y(), yaw};
    const double x = size.x() / 2.0;
    const double y = size.y() / 2.0;
    const Point2 points[] = {T_map_box * Point2(-x, -y), T_map_box * Point2(x, -y),
                             T_map_box * Point2(x, y), T_map_box * Point2(-x, y)};
    return polygon(points);
  }

  [[nodiscard]] const std::vector<Wall>& walls() const { return walls_; }

  /// Metres along `heading` to the nearest wall; infinity when there is none.
  [[nodiscard]] double range(const Point2& origin, double heading) const {
    // In plain numbers: the innermost loop of all simulated scans, and tests run unoptimised, too.
    const double ray_x = std::cos(heading);
    const double ray_y = std::sin(heading);
    const double x = origin.x();
    const double y = origin.y();
    double nearest = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls_) {
      const double* a = wall.a.data();
      const double* b = wall.b.data();
      const double along_x = b[0] - a[0];
      const double along_y = b[1] - a[1];
      const double determinant = ray_x * along_y - ray_y * along_x;
      if (std::abs(determinant) < 1e-12) continue;
      const double distance = ((a[0] - x) * along_y - (a[1] - y) * along_x) / determinant;
      const double share = ((a[0] - x) * ray_y - (a[1] - y) * ray_x) / determinant;
      if (distance > 0.0 && share >= 0.0 && share <= 1.0) nearest = std::min(nearest, distance);
    }
    return nearest;
  }

  /// Metres to the nearest wall; infinity when there is none.
  [[nodiscard]] double distance_to_walls(const Point2& point) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls_) {
      const Point2 along = wall.b - wall.a;
      const double share = (point - wall.a).dot(along) / along.squaredNorm();
      const Point2 foot = wall.a + std::clamp(share, 0.0, 1.0) * along;
      nearest = std::min(nearest, (foot - point).norm());
    }
    return nearest;
  }

  /// Whether nothing stands between two points; a wall through `target` itself does not count.
  [[nodiscard]] bool sees(const Point2& origin, const Point2& target) const {
    const Point2 to_target = target - origin;
    return range(origin, std::atan2(to_target.y(), to_target.x())) > to_target.norm() - 1e-6;
  }

  /// Points where two walls end together.
  [[nodiscard]] std::vector<Point2> corners() const {
    std::vector<Point2> points;
    for (const Corner& corner : joined_ends()) points.push_back(corner.position);
    return points;
  }

  /// Those with `arm_m` of both walls in sight of `origin` at no grazing angle: the corners that a
  /// lidar there must find.
  [[nodiscard]] std::vector<Point2> corners_seen(const Point2& origin, double arm_m) const {
    std::vector<Point2> points;
    for (const Corner& corner : joined_ends()) {
      if (sees_arm(origin, corner.position, corner.end_of_first, arm_m) &&
          sees_arm(origin, corner.position, corner.end_of_second, arm_m)) {
        points.push_back(corner.position);
      }
    }
    return points;
  }

  /// The same scene in another frame.
  [[nodiscard]] SceneBuilder moved(const Pose2& T) const {
    SceneBuilder result;
    for (const Wall& w : walls_) result.wall(T * w.a, T * w.b);
    return result;
  }

 private:
  static constexpr double kGrazingRad = 0.2;

  struct Corner {
    Point2 position;
    Point2 end_of_first;
    Point2 end_of_second;
  };

  [[nodiscard]] std::vector<Corner> joined_ends() const {
    std::vector<Corner> corners;
    const auto join = [&](const Wall& first, const Wall& second) {
      if ((first.a - second.a).norm() < 1e-9) corners.push_back({first.a, first.b, second.b});
    };
    for (std::size_t i = 0; i < walls_.size(); ++i) {
      for (std::size_t j = i + 1; j < walls_.size(); ++j) {
        const Wall first = walls_[i];
        const Wall second = walls_[j];
        join(first, second);
        join(first, {second.b, second.a});
        join({first.b, first.a}, second);
        join({first.b, first.a}, {second.b, second.a});
      }
    }
    return corners;
  }

  [[nodiscard]] bool sees_arm(const Point2& origin, const Point2& corner, const Point2& end,
                              double arm_m) const {
    if ((end - corner).norm() < arm_m) return false;
    const Point2 along = (end - corner).normalized();
    const Point2 beam = (corner + arm_m * along - origin).normalized();
    if (std::abs(cross(beam, along)) < std::sin(kGrazingRad)) return false;
    return std::ranges::all_of(std::vector{0.02, 0.25, 0.5, 0.75, 1.0}, [&](double share) {
      return sees(origin, corner + share * arm_m * along);
    });
  }

  std::vector<Wall> walls_;
};

/// Two walls of 3 m that meet at (3, 0), each turned by `half_angle` from the x axis. A lidar at
/// the origin looks into the corner when the walls come towards it.
[[nodiscard]] inline SceneBuilder wedge(double half_angle) {
  const Point2 tip(3.0, 0.0);
  return SceneBuilder()
      .wall(tip, tip + 3.0 * Point2(-std::cos(half_angle), std::sin(half_angle)))
      .wall(tip, tip + 3.0 * Point2(-std::cos(half_angle), -std::sin(half_angle)));
}

/// The walls of figure7_room() without what stands in it.
[[nodiscard]] inline SceneBuilder figure7_outline() {
  const Point2 outline[] = {{2, 0},    {8.6, 0},  {8.6, 1.5}, {10, 1.5}, {10, 8.2}, {8.5, 8.2},
                            {8.5, 10}, {1.5, 10}, {1.5, 8},   {0, 8},    {0, 2.5},  {2, 2.5}};
  return SceneBuilder().polygon(outline);
}

/// A room after the paper's figure 7: 10 m by 10 m with offset corners and two obstacles, 14
/// corners in sight of the paper's lidar at (7.5, 5).
[[nodiscard]] inline SceneBuilder figure7_room() {
  return figure7_outline().box({5.0, 1.4}, {1.5, 1.5}, 0.5).box({5.2, 8.4}, {1.5, 1.5}, 1.1);
}

}  // namespace cornerfix::testing

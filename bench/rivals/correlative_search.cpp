#include "bench/rivals/correlative_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/src/matching/scan_refiner.hpp"

namespace cornerfix::bench {
namespace {

struct Scored {
  Pose2 T_grid_base_link;
  float score = 0.0F;
};

std::vector<Point2> thinned(std::span<const Point2> points, std::size_t max_points) {
  const std::size_t step = std::max<std::size_t>(1, (points.size() + max_points - 1) / max_points);
  std::vector<Point2> kept;
  for (std::size_t i = 0; i < points.size(); i += step) kept.push_back(points[i]);
  return kept;
}

/// What a point is worth by its distance, in steps of the field.
std::array<float, 256> worth_by_distance(double sigma_m) {
  std::array<float, 256> worth{};
  for (std::size_t i = 0; i < worth.size(); ++i) {
    const double deviation = DistanceField::kStep * static_cast<double>(i) / sigma_m;
    worth[i] = static_cast<float>(std::exp(-0.5 * deviation * deviation));
  }
  return worth;
}

/// The best, none within 1 m and 15 deg of a better one.
std::vector<Scored> best_distinct(std::vector<Scored> places, std::size_t count) {
  constexpr double kDistinct = 1.0;
  constexpr double kDistinctAngle = 0.26;
  std::ranges::sort(places, std::greater{}, &Scored::score);
  std::vector<Scored> best;
  for (const Scored& place : places) {
    if (best.size() == count) break;
    const bool known = std::ranges::any_of(best, [&](const Scored& other) {
      return distance(place.T_grid_base_link, other.T_grid_base_link) < kDistinct &&
             angle_between(place.T_grid_base_link, other.T_grid_base_link) < kDistinctAngle;
    });
    if (!known) best.push_back(place);
  }
  return best;
}

}  // namespace

CorrelativeSearch::CorrelativeSearch(const OccupancyGrid& grid, const DistanceField& field,
                                     const CorrelativeSearchParams& params)
    : field_(field), params_(params) {
  const int step =
      std::max(1, static_cast<int>(std::lround(params.position_step_m / grid.resolution)));
  for (int row = 0; row < grid.height; row += step) {
    for (int column = 0; column < grid.width; column += step) {
      if (grid.at({column, row}) == Cell::kFree) places_.push_back(grid.center({column, row}));
    }
  }
}

std::optional<Pose2> CorrelativeSearch::find(std::span<const Point2> ends_base_link) const {
  if (ends_base_link.empty()) return std::nullopt;
  const std::vector<Point2> points = thinned(ends_base_link, params_.max_points);
  const std::array<float, 256> worth = worth_by_distance(params_.sigma_m);
  const std::span<const std::uint8_t> steps = field_.steps();
  const double cells_per_m = 1.0 / field_.resolution();
  std::vector<Scored> best_a_place(places_.size());
  std::vector<Eigen::Vector2f> turned(points.size());
  for (double yaw = -std::numbers::pi; yaw < std::numbers::pi; yaw += params_.angle_step_rad) {
    const Pose2 T_turned{0.0, 0.0, yaw};
    for (std::size_t i = 0; i < points.size(); ++i)
      turned[i] = (cells_per_m * (T_turned * points[i])).cast<float>();
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const Eigen::Vector2f at = (cells_per_m * places_[k]).cast<float>();
      float score = 0.0F;
      for (const Eigen::Vector2f& point : turned) {
        const auto column = static_cast<unsigned>(static_cast<int>(at.x() + point.x()));
        const auto row = static_cast<unsigned>(static_cast<int>(at.y() + point.y()));
        if (column >= static_cast<unsigned>(field_.width()) ||
            row >= static_cast<unsigned>(field_.height()))
          continue;
        score +=
            worth[steps[static_cast<std::size_t>(row) * static_cast<std::size_t>(field_.width()) +
                        column]];
      }
      if (score > best_a_place[k].score)
        best_a_place[k] = {{places_[k].x(), places_[k].y(), wrap_angle(yaw)}, score};
    }
  }
  const Pose2 T_map_grid = inverse(field_.T_grid_frame());
  RefinedPose best;
  best.inlier_share = params_.min_share;
  bool found = false;
  for (const Scored& place : best_distinct(std::move(best_a_place), params_.refined)) {
    const Pose2 start = T_map_grid * place.T_grid_base_link;
    const RefinedPose coarse =
        refine_pose(field_, points, start, {.kernel_m = 0.3, .max_iterations = 20});
    const RefinedPose fine = refine_pose(field_, ends_base_link, coarse.T_frame_base_link,
                                         {.kernel_m = params_.wall_distance_m});
    if (fine.inlier_share < best.inlier_share) continue;
    best = fine;
    found = true;
  }
  return found ? std::optional(best.T_frame_base_link) : std::nullopt;
}

}  // namespace cornerfix::bench

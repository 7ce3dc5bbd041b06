#include "core/src/map/distance_field.hpp"

#include <cmath>

#include "core/src/scan/wall_distance.hpp"

namespace cornerfix {

DistanceField::DistanceField(const Pose2& T_frame_grid, double resolution, int width, int height)
    : T_grid_frame_(inverse(T_frame_grid)),
      resolution_(resolution),
      inverse_resolution_(1.0 / resolution),
      width_(width),
      height_(height),
      steps_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 255) {}

DistanceField::DistanceField(const OccupancyGrid& grid)
    : DistanceField(grid.T_map_grid, grid.resolution, grid.width, grid.height) {
  const std::vector<float> distance_cells = distances_to_walls(grid);
  const float steps_per_cell = static_cast<float>(resolution_ / kStep);
  std::ranges::transform(distance_cells, steps_.begin(), [&](float cells) {
    return static_cast<std::uint8_t>(std::min(255.0F, std::round(cells * steps_per_cell)));
  });
}

void DistanceField::stamp(const Point2& point_grid, double radius_m) {
  const double column = point_grid.x() * inverse_resolution_ - 0.5;
  const double row = point_grid.y() * inverse_resolution_ - 0.5;
  const double reach = radius_m * inverse_resolution_;
  const int first_column = std::max(0, static_cast<int>(std::ceil(column - reach)));
  const int last_column = std::min(width_ - 1, static_cast<int>(std::floor(column + reach)));
  const int first_row = std::max(0, static_cast<int>(std::ceil(row - reach)));
  const int last_row = std::min(height_ - 1, static_cast<int>(std::floor(row + reach)));
  const float steps_per_cell = static_cast<float>(resolution_ / kStep);
  for (int r = first_row; r <= last_row; ++r) {
    const float dy = static_cast<float>(r - row);
    for (int c = first_column; c <= last_column; ++c) {
      const float dx = static_cast<float>(c - column);
      const float steps = std::sqrt(dx * dx + dy * dy) * steps_per_cell;
      std::uint8_t& cell = steps_[index(c, r)];
      if (steps < static_cast<float>(cell)) cell = static_cast<std::uint8_t>(steps);
    }
  }
}

}  // namespace cornerfix

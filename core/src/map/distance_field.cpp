#include "core/src/map/distance_field.hpp"

#include <cmath>

#include "core/src/map/stamp_patch.hpp"
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

void DistanceField::stamp(std::span<const Point2> points_grid, double radius_m) {
  for_each_patch(*this, points_grid, radius_m, [this](const StampPatch& patch) {
    const int columns = patch.last_column() - patch.first_column() + 1;
    for (int row = patch.first_row(); row <= patch.last_row(); ++row) {
      const std::uint8_t* lowered = patch.cells(patch.first_column(), row);
      std::uint8_t* to = &steps_[index(patch.first_column(), row)];
      for (int i = 0; i < columns; ++i) to[i] = std::min(to[i], lowered[i]);
    }
  });
}

}  // namespace cornerfix

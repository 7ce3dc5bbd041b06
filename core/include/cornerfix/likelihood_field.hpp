/// \file  Distance from any point to the nearest wall of an occupancy grid, by look-up.
#pragma once

#include <cstdint>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>

namespace cornerfix {

/// Distance transform of a grid, quantised to a byte a cell (1 cm steps up to 2.54 m), with the
/// cell class beside it. Immutable: any threads may share it.
class LikelihoodField {
 public:
  /// O(cells).
  explicit LikelihoodField(const OccupancyGrid& grid);

  static constexpr double kMaxDistance = 2.54;  ///< Farther is reported as this [m].

  /// Metres to the nearest wall, bilinear between cell centres; kMaxDistance outside the grid.
  /// Point in `map`.
  [[nodiscard]] double distance(const Point2& point_map) const;
  [[nodiscard]] Cell cell(const Point2& point_map) const;

 private:
  Pose2 T_grid_map_;
  double inverse_resolution_ = 0.0;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> distance_cm_;
  std::vector<Cell> cells_;
};

}  // namespace cornerfix

/// \file  The plain alternative to features: all places of the map tried with one scan, the best
/// ones brought home by ICP.
///
/// Correlative scan matching as of Olson 2009 (real-time correlative scan matching) at one coarse
/// resolution over the whole map, then the ICP of scan_refiner.hpp.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>

#include "core/src/map/distance_field.hpp"

namespace cornerfix::bench {

struct CorrelativeSearchParams {
  double position_step_m = 0.3;
  double angle_step_rad = 0.0698;  ///< 4 deg
  double sigma_m = 0.2;            ///< Of a point's distance to the nearest wall.
  std::size_t max_points = 90;     ///< Evenly thinned.
  std::size_t refined = 20;        ///< Best distinct places given to ICP.
  double wall_distance_m = 0.1;    ///< A point this near to a wall is explained.
  double min_share = 0.6;          ///< Of the points that must be explained.
};

/// Of one map. Immutable: any threads may share it.
class CorrelativeSearch {
 public:
  /// `grid` and `field` must outlive it. O(cells).
  CorrelativeSearch(const OccupancyGrid& grid, const DistanceField& field,
                    const CorrelativeSearchParams& params = {});

  /// O(free area * headings * points).
  [[nodiscard]] std::optional<Pose2> find(std::span<const Point2> ends_base_link) const;

  [[nodiscard]] std::size_t bytes() const { return places_.size() * sizeof(Point2); }

 private:
  const DistanceField& field_;
  CorrelativeSearchParams params_;
  std::vector<Point2> places_;  ///< In known-free space, in frame `grid` of the field.
};

}  // namespace cornerfix::bench

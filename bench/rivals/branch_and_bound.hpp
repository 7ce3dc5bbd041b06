/// \file  Cartographer's search for the pose of one scan: branch and bound over a grid of
/// probabilities.
///
/// Hess et al. 2016 (real-time loop closure in 2D lidar SLAM), section V, algorithms 2 and 3, with
/// the settings of Cartographer's fast correlative scan matcher. Unlike there, the robot itself
/// must lie in the grid, which leaves fewer places to look at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

#include "bench/rivals/probability_grid.hpp"

namespace cornerfix::bench {

/// Where to look: about a pose, or everywhere.
struct SearchWindow {
  Pose2 T_map_base_link;
  double distance_m = std::numeric_limits<double>::infinity();  ///< Along each axis.
  double angle_rad = std::numbers::pi;                          ///< To each side.
};

struct ScanMatch {
  Pose2 T_map_base_link;
  double score = 0.0;  ///< Mean probability of the cells that the points fall in.
};

/// The pyramid of one grid. Immutable: any threads may share it.
class BranchAndBoundMatcher {
 public:
  /// \param depth  Levels of the pyramid; the top one has blocks of 2^(depth - 1) cells; >= 1.
  BranchAndBoundMatcher(const ProbabilityGrid& grid, int depth);

  /// The best pose in the window, if its score is over `min_score`.
  [[nodiscard]] std::optional<ScanMatch> match(std::span<const Point2> points_base_link,
                                               const SearchWindow& window, double min_score) const;

  [[nodiscard]] std::size_t bytes() const;

 private:
  /// Of each cell, the largest value of the 2^h by 2^h cells from there on to the upper right.
  /// Begins 2^h - 1 cells to the lower left of the grid.
  struct Level {
    int margin = 0;
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> values;

    [[nodiscard]] std::uint8_t at(int column, int row) const {
      const auto x = static_cast<unsigned>(column + margin);
      const auto y = static_cast<unsigned>(row + margin);
      if (x >= static_cast<unsigned>(width) || y >= static_cast<unsigned>(height)) return 0;
      return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + x];
    }
  };
  struct Rotation;
  struct Candidate;
  struct Search;

  double resolution_;
  Point2 origin_map_;
  int width_;
  int height_;
  std::vector<Level> levels_;
};

/// At most about `min_points`, one a square cell: the largest cells, up to `max_length_m`, that
/// leave so many (Cartographer's adaptive voxel filter).
[[nodiscard]] std::vector<Point2> thin_adaptively(std::span<const Point2> points,
                                                  std::size_t min_points, double max_length_m);

}  // namespace cornerfix::bench

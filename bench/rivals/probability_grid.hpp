/// \file  An occupancy grid of probabilities, as Cartographer makes it of scans at poses.
///
/// Hess et al. 2016, section IV-C, eqs. (2)-(3): each scan raises the odds of the cells where its
/// beams end and lowers those of the cells that they pass.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix::bench {

/// Defaults: those of Cartographer.
struct ProbabilityGridParams {
  double resolution_m = 0.05;
  double hit_probability = 0.55;
  double miss_probability = 0.49;
  double max_range_m = 30.0;  ///< Longer returns are left out.
};

/// Row-major, row 0 at the lowest y; axes parallel to those of `map`.
struct ProbabilityGrid {
  static constexpr double kMin = 0.1;  ///< Also of unknown cells.
  static constexpr double kMax = 0.9;

  double resolution = 0.05;            ///< [m/cell]
  Point2 origin_map = Point2::Zero();  ///< Lower left corner of cell (0, 0).
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> values;  ///< 0 is kMin, 255 is kMax.

  [[nodiscard]] static double probability(double value) {
    return kMin + value * (kMax - kMin) / 255.0;
  }
};

/// Empty for no scans. O(scans * beams * range / resolution).
[[nodiscard]] ProbabilityGrid build_probability_grid(std::span<const PosedScan> scans,
                                                     const ProbabilityGridParams& params);

}  // namespace cornerfix::bench

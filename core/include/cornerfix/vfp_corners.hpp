/// \file  The paper's corners, vector feature points: a coarse smoothness score, then a filter on
/// two vectors.
///
/// Peng et al. 2023, section 2, eqs. (1)-(6), algorithm 1.
#pragma once

#include <span>
#include <vector>

#include <cornerfix/feature_map.hpp>
#include <cornerfix/laser_scan.hpp>
#include <cornerfix/scan_segments.hpp>

namespace cornerfix {

/// Defaults for fine scanners; see docs/algorithm.md for where they come from. A scan coarser than
/// `coarse_increment_rad` takes the second set.
struct VfpParams {
  ScanSegmentParams segments;
  int window = 10;                    ///< W of eq. (1): points on each side; >= 1.
  double min_score = 0.001;           ///< t_c; >= 0.
  double neighbor_distance_m = 0.5;   ///< t_neigh; > 0.
  double inlier_distance_m = 0.15;    ///< t_in; > 0.
  double min_turn_angle_rad = 0.61;   ///< t_a; in (0, pi).
  double suppression_radius_m = 0.5;  ///< Keep the largest a within this; > 0.
};

/// Defaults for scanners of about 1 deg a beam (algorithm.md, section 8).
[[nodiscard]] VfpParams vfp_params_for(double angle_increment_rad);

[[nodiscard]] std::optional<Error> validate(const VfpParams& params);

/// c of eq. (1) for each point of a segment, the LOAM smoothness. Points nearer than `window` to an
/// end use the part of the window that exists. O(n) by running sums.
[[nodiscard]] std::vector<double> smoothness_scores(std::span<const ScanPoint> segment, int window);

/// Corners of one scan in `laser`, by ascending beam. `weight` and `turn_angle` are a of eq. (6).
/// O(beams + m^2) for m coarse points, as published.
[[nodiscard]] std::vector<Feature> extract_vfp_corners(const LaserScan& scan,
                                                       const VfpParams& params);

}  // namespace cornerfix

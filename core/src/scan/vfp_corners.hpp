/// \file  The paper's corners, vector feature points: a coarse smoothness score, then a filter on
/// two vectors.
///
/// Peng et al. 2023, section 2, eqs. (1)-(6), algorithm 1.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <cornerfix/corners.hpp>
#include <cornerfix/laser_scan.hpp>
#include <cornerfix/result.hpp>

#include "core/src/scan/scan_segments.hpp"

namespace cornerfix {

/// Defaults for fine scanners (0.25 deg per beam); see docs/method/02-corners.md.
struct VfpParams {
  ScanSegmentParams segments{};
  int window = 10;                    ///< W of eq. (1): points on each side; >= 1.
  double min_score = 0.001;           ///< t_c; >= 0.
  double neighbor_distance_m = 0.5;   ///< t_neigh; > 0.
  double inlier_distance_m = 0.15;    ///< t_in; > 0.
  double min_turn_angle_rad = 0.61;   ///< t_a; in (0, pi).
  double suppression_radius_m = 0.5;  ///< Keep the largest a within this; > 0.
};

/// Parameters for a scanner with this angle between beams, between those for 0.25 deg and for 1 deg
/// (docs/method/02-corners.md, section 2.2).
[[nodiscard]] VfpParams vfp_params_for(double angle_increment_rad);

[[nodiscard]] std::optional<Error> validate(const VfpParams& params);

/// c of eq. (1) for each point of a segment, the LOAM smoothness. Points nearer than `window` to an
/// end use the part of the window that exists. O(n) by running sums.
[[nodiscard]] std::vector<double> smoothness_scores(std::span<const ScanPoint> segment, int window);

/// Corners of one scan in `laser`, by ascending beam. `weight` and `turn_angle` are a of eq. (6),
/// `bisector` is the heading of L + R. `params` must pass validate().
/// O(beams + m * n) for m coarse points with n points within t_neigh.
[[nodiscard]] std::vector<Feature> extract_vfp_corners(const LaserScan& scan,
                                                       const VfpParams& params);

}  // namespace cornerfix

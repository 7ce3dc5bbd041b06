/// \file  Corners by the smoothness score of LOAM alone: what the paper's vector filter starts
/// from.
///
/// Zhang, Singh 2014 (LOAM), eq. (1); Peng et al. 2023, eq. (1).
#pragma once

#include <vector>

#include <cornerfix/corners.hpp>
#include <cornerfix/laser_scan.hpp>

#include "core/src/scan/vfp_corners.hpp"

namespace cornerfix::bench {

/// The points of a scan whose score is over `params.min_score`, the score as their weight, in
/// `laser`. Of the parameters only segments, window and min_score count.
[[nodiscard]] std::vector<Feature> extract_loam_corners(const LaserScan& scan,
                                                        const VfpParams& params);

}  // namespace cornerfix::bench

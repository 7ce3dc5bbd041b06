/// \file  How two scans lie to each other, told by nothing but the two scans.
///
/// Point-to-line ICP (Censi 2008, "An ICP variant using a point-to-line metric"). It has nothing in
/// common with how drives are mapped here, nor with whoever made a log's reference poses, so that
/// it can judge between them.
#pragma once

#include <optional>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix::cli {

/// The pose of the laser at scan `b` in the laser frame at scan `a`, T_a_b.
///
/// \param guess  Within some 0.5 m and 0.3 rad of it.
/// \return Nothing where too few points of one scan lie on walls of the other, or where these all
///         run one way, as in a bare corridor. O(beams^2) an iteration.
[[nodiscard]] std::optional<Pose2> register_scans(const LaserScan& a, const LaserScan& b,
                                                  const Pose2& guess);

}  // namespace cornerfix::cli

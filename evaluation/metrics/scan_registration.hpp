/// \file  The relative pose of two scans, from nothing but the two scans.
///
/// Point-to-line ICP (Censi 2008, "An ICP variant using a point-to-line metric"). It shares no step
/// with the mapping of runs here, nor with how a log's reference poses were made. So it can judge
/// between them. It sees the same scans, with the same noise.
#pragma once

#include <optional>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix::evaluation {

struct Registration {
  Pose2 T_a_b;                ///< The laser at scan `b` in the laser frame at scan `a`.
  double inlier_share = 0.0;  ///< Of the points of `b`: those within 0.06 m of a wall of `a`.
};

/// \param guess  Of T_a_b, within some 0.5 m and 0.3 rad.
/// \return Nothing where it does not converge, or where too few points of one scan lie on walls of
///         the other. Nothing either where these walls do not constrain a whole pose: a bare
///         corridor, a round hall. Scans are thinned to 360 returns, so a call takes a few ms.
[[nodiscard]] std::optional<Registration> register_scans(const LaserScan& a, const LaserScan& b,
                                                         const Pose2& guess);

}  // namespace cornerfix::evaluation

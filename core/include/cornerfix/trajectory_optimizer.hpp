/// \file  A mapping drive without drift: loop closures found, verified and spread over all poses.
///
/// The drive is cut into overlapping rigid submaps. Each is looked for among the older ones by the
/// map search that localizes robots (place_search.hpp), and believed by the same evidence
/// (evidence_model.hpp). Then every key frame is laid on every submap around it, and a pose graph
/// over key frames and submaps finds the poses that agree best. After Hess et al. 2016.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

struct OptimizedTrajectory {
  std::vector<Pose2> T_map_base_link;  ///< One a key frame; the first is the identity.
  std::size_t submaps = 0;
  std::size_t loop_closures = 0;  ///< Submaps that were found among older ones.
};

/// \param drive     Key frames at the poses of lidar odometry, in the order of driving.
/// \param progress  Called with the share done, in [0, 1]; may be empty.
/// \return kInternal when the pose graph has no solution.
///
/// Deterministic, keeps no state. O(submaps * area of the map + key frames * beams).
[[nodiscard]] Result<OptimizedTrajectory> optimize_trajectory(
    std::span<const PosedScan> drive, const std::function<void(double)>& progress = {});

}  // namespace cornerfix

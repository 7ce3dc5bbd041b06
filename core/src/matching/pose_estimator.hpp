/// \file  Rigid 2D pose from feature correspondences, in spite of wrong ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/localizer_params.hpp>
#include <cornerfix/pose2.hpp>

#include "core/src/matching/correspondence.hpp"

namespace cornerfix {

/// A candidate answer to "where does the submap lie in the map?".
struct PoseEstimate {
  Pose2 T_map_submap;                ///< Takes points of `submap` into `map`.
  std::vector<std::size_t> inliers;  ///< Ascending indices into the input.
  double rms_residual_m = 0.0;       ///< Over the inliers.
};

/// Least-squares rigid transform for correspondences taken as all true. Nothing when they do not
/// fix the rotation: fewer than two, all in one point, or each other's mirror image.
[[nodiscard]] std::optional<Pose2> fit_rigid(std::span<const Correspondence> correspondences);

/// Finds the pose that the most correspondences agree on: RANSAC over pairs, closed form over the
/// inliers. A submap point counts once, however many map points are offered for it. Nothing when no
/// pose gathers `min_inliers`: an answer, not an error. O(max_iterations * n). Keeps no state, so
/// any threads may call it at once. Peng et al. 2023, section 3.3, eq. (16).
[[nodiscard]] std::optional<PoseEstimate> estimate_pose(
    std::span<const Correspondence> correspondences, const PoseEstimatorParams& params);

}  // namespace cornerfix

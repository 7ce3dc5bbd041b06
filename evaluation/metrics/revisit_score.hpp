/// \file  How well trajectories agree with the scans themselves, where a run came back.
///
/// Reference poses of recorded runs come from SLAM, too. Where they differ from a trajectory,
/// either may be wrong. Two scans of one place, taken far apart on the path, have a relative pose
/// of their own (`register_scans`). It decides between any trajectories.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

#include "evaluation/datasets/log_reader.hpp"
#include "evaluation/metrics/trajectory_score.hpp"

namespace cornerfix::evaluation {

struct RevisitScore {
  std::size_t pairs = 0;                  ///< Of scans whose registration gave a relative pose.
  std::size_t undecided = 0;              ///< Other pairs that were looked at.
  std::vector<RelativePoseError> errors;  ///< Of each trajectory, one a pair.
};

/// \param indices       Scans to judge by, in the order of the run.
/// \param trajectories  One or more, each a pose for each of `scans`, in a frame of its own.
///
/// Pairs are each scan and the nearest earlier one within 1.5 m and 40 deg by any of the
/// trajectories, with a path of at least 20 m between them. There are 500 at most. The scans are
/// registered from where each trajectory has them. Where that gives different poses (1 cm, 0.2
/// deg), the one with clearly more points on walls is used. So a trajectory that is far off gets a
/// large error. If none has clearly more, the pair is undecided.
[[nodiscard]] RevisitScore score_revisits(std::span<const LogScan> scans,
                                          std::span<const std::size_t> indices,
                                          std::span<const std::vector<Pose2>> trajectories);

}  // namespace cornerfix::evaluation

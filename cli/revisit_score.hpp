/// \file  How well trajectories agree with the scans themselves, where a drive came back.
///
/// Reference poses of recorded drives come from SLAM, too, and where they differ from a trajectory
/// it may be they that are wrong. Two scans of one place, taken many metres of way apart, tell how
/// they lie to each other by themselves (`register_scans`): a judge between any trajectories.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

#include "cli/log_reader.hpp"
#include "cli/trajectory_score.hpp"

namespace cornerfix::cli {

struct RevisitScore {
  std::size_t pairs = 0;                  ///< Of scans that told how they lie to each other.
  std::size_t undecided = 0;              ///< Other pairs that were looked at.
  std::vector<RelativePoseError> errors;  ///< Of each trajectory, one a pair.
};

/// \param indices       Scans to judge by, in the order of the drive.
/// \param trajectories  One or more, each a pose for each of `scans`, in a frame of its own.
///
/// Pairs are each scan and the nearest earlier one that is at least 20 m of way back, within 1.5 m
/// and 40 deg, as any of the trajectories says; 500 at most. The scans are registered from where
/// each trajectory has them. Where that gives different poses (1 cm, 0.2 deg), the one with clearly
/// more points on walls holds, so that a trajectory that is far off is told so; if none has, the
/// pair is undecided.
[[nodiscard]] RevisitScore score_revisits(std::span<const LogScan> scans,
                                          std::span<const std::size_t> indices,
                                          std::span<const std::vector<Pose2>> trajectories);

}  // namespace cornerfix::cli

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

/// \param indices       Scans to judge by, in the order of the drive.
/// \param trajectories  One or more, each a pose for each of `scans`, in a frame of its own. The
///                      first one tells where the drive came back.
/// \return For each trajectory its errors against the registered scans: of each scan and the
/// nearest
///         earlier one that is at least 20 m of way back, within 1.5 m and 40 deg. Pairs whose
///         registrations from the trajectories end in different poses (1 cm, 0.2 deg) tell nothing
///         and are left out, so all are judged by the same pairs, 1,000 at most.
[[nodiscard]] std::vector<RelativePoseError> revisit_errors(
    std::span<const LogScan> scans, std::span<const std::size_t> indices,
    std::span<const std::vector<Pose2>> trajectories);

}  // namespace cornerfix::cli

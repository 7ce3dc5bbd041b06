/// \file  How well a trajectory agrees with a log's reference poses.
///
/// Kuemmerle et al. 2009, "On Measuring the Accuracy of SLAM Algorithms". The error is that of
/// relative poses, so that an early mistake is not counted again by all that follows. Relations are
/// those between reference poses a given path length apart.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

/// Errors of relative poses over one path length.
struct RelativePoseError {
  double path_length_m = 0.0;
  std::vector<double> errors_m;
  std::vector<double> errors_rad;
};

/// Indices of the scans whose reference pose may be judged by: with a pose, and in a log that marks
/// key scans those only, since poses between them are interpolated.
[[nodiscard]] std::vector<std::size_t> reference_scans(std::span<const LogScan> scans);

/// \param T_any_laser  A pose for each of `scans`, in any frame.
/// A relation goes from each reference scan to the first one that is at least `path_length_m`
/// farther.
[[nodiscard]] RelativePoseError relative_pose_error(std::span<const LogScan> scans,
                                                    std::span<const Pose2> T_any_laser,
                                                    double path_length_m);

/// The rigid motion that takes the positions of `T_any_laser` to the reference positions with the
/// least squared error: T_map_any. The identity without reference.
[[nodiscard]] Pose2 align_to_reference(std::span<const LogScan> scans,
                                       std::span<const Pose2> T_any_laser);

}  // namespace cornerfix::evaluation

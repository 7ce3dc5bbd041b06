/// \file  SLAM over a recorded run, without a look at its reference poses.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include <cornerfix/mapper.hpp>
#include <cornerfix/result.hpp>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

struct SlamRun {
  std::vector<Pose2> T_map_laser;      ///< One a scan; `map` is the laser at the first.
  std::vector<std::size_t> key_scans;  ///< Indices of the scans that became keyframes.
  std::size_t submaps = 0;
  std::size_t loop_closures = 0;
};

/// `progress` is called with the share done and may be empty.
[[nodiscard]] Result<SlamRun> run_slam(std::span<const LogScan> scans, bool use_odometry,
                                       const MapperParams& params,
                                       const std::function<void(double)>& progress);

}  // namespace cornerfix::evaluation

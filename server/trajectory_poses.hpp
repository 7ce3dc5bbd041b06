/// \file  A trajectory that was optimised elsewhere, laid on a map's keyframes.
#pragma once

#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/result.hpp>

#include "api/requests.hpp"

namespace cornerfix::server {

/// The pose of each keyframe's stamp (nearest within 1 ms), in their order. kInvalidArgument, with
/// the stamps that are missing, when some have none. O(n log n).
[[nodiscard]] Result<std::vector<Pose2>> poses_of(const std::vector<PosedScan>& key_frames,
                                                  std::span<const api::StampedPose> given);

}  // namespace cornerfix::server

/// \file  Scans that a map is to grow by: which are new, and what is wrong with them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/mapper.hpp>
#include <cornerfix/result.hpp>
#include <cornerfix/slam.hpp>

#include "storage/map_store.hpp"

namespace cornerfix::server {

/// Why a map with keyframes cannot take scans that come with poses, or without.
[[nodiscard]] std::optional<Error> mixed(const storage::MapInfo& map, bool scans_have_poses);

/// The scans whose stamps the map does not know and that are not earlier in the batch. `Scan` is
/// PosedScan or RobotScan, here and below.
template <typename Scan>
[[nodiscard]] std::vector<const Scan*> new_scans(std::span<const Scan> scans,
                                                 const std::vector<bool>& known);

/// A scan of a run without poses must come after what is there of it. \param fresh  Of `scans`.
[[nodiscard]] std::optional<Error> too_late(std::span<const RobotScan* const> fresh,
                                            std::span<const RobotScan> scans, const Mapper& mapper);

/// The scan where it was taken: at the pose it came with, or where odometry has it. Its beams
/// without return are NaN in any case, so that the map's digest is the same.
[[nodiscard]] PosedScan posed_by(LidarOdometry& odometry, const PosedScan& scan);
[[nodiscard]] PosedScan posed_by(LidarOdometry& odometry, const RobotScan& scan);

}  // namespace cornerfix::server

/// \file  Lidars, scans and poses as the HTTP API takes them. Logs know the laser only, so it is
/// posted as base_link with the laser mounted at its origin.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::client {

[[nodiscard]] nlohmann::ordered_json pose_json(const Pose2& pose);
[[nodiscard]] nlohmann::ordered_json lidar_json(const evaluation::LogHeader& header);

/// The scan as a server reads it from the JSON below: ranges in tenths of a millimetre.
[[nodiscard]] LaserScan as_sent(LaserScan scan);
/// At the reference poses, which all scans have.
[[nodiscard]] std::vector<PosedScan> posed_scans_as_sent(
    std::span<const evaluation::LogScan> scans);
/// With odometry where there is any.
[[nodiscard]] std::vector<RobotScan> robot_scans_as_sent(
    std::span<const evaluation::LogScan> scans);
/// With the scan's reference pose, for mapping; with its own geometry where that is not the log's.
[[nodiscard]] nlohmann::ordered_json posed_scan_json(const evaluation::LogHeader& header,
                                                     const evaluation::LogScan& scan);
/// With odometry where there is any and it is wanted, as a robot posts it; with its own geometry
/// where that is not the log's.
[[nodiscard]] nlohmann::ordered_json robot_scan_json(const evaluation::LogHeader& header,
                                                     const evaluation::LogScan& scan,
                                                     bool with_odometry);

/// An {x, y, yaw} object, or nothing.
[[nodiscard]] std::optional<Pose2> pose_from_json(const nlohmann::json& json);

}  // namespace cornerfix::client

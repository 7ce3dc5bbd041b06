/// \file  Two drives through one room: one that maps it, one of a robot that must find itself.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include <cornerfix/laser_scan.hpp>

#include "support/scan_simulator.hpp"
#include "support/scene_builder.hpp"

namespace cornerfix::testing {

inline constexpr double kScanPeriodS = 0.2;
inline const Point2 kOldObstacle{5.2, 8.4};  ///< In figure7_room() only.
inline const Point2 kNewObstacle{8.9, 4.5};  ///< In refurnished_room() only.

/// Poses along a circle about the middle of figure7_room(), looking along it.
[[nodiscard]] inline std::vector<Pose2> circle_in_room(double radius_m, double begin_rad,
                                                       double step_rad, std::size_t count) {
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = begin_rad + static_cast<double>(i) * step_rad;
    poses.push_back({5.0 + radius_m * std::cos(angle), 5.0 + radius_m * std::sin(angle),
                     wrap_angle(angle + std::numbers::pi / 2.0)});
  }
  return poses;
}

/// The same room later: one obstacle was carried away, another one put in.
[[nodiscard]] inline SceneBuilder refurnished_room() {
  return figure7_outline().box({5.0, 1.4}, {1.5, 1.5}, 0.5).box(kNewObstacle, {1.2, 0.8}, 0.2);
}

[[nodiscard]] inline LaserScan scan_in_room(const Pose2& T_map_base_link, double stamp,
                                            const SceneBuilder& room = figure7_room()) {
  LaserScan scan = simulate_scan(room, {.beams = 360}, T_map_base_link);
  scan.stamp = stamp;
  return scan;
}

/// Once around the room: enough for a map.
[[nodiscard]] inline std::vector<PosedScan> mapping_drive(
    double first_stamp = 100.0, const SceneBuilder& room = figure7_room()) {
  std::vector<PosedScan> drive;
  double stamp = first_stamp;
  for (const Pose2& pose : circle_in_room(2.2, 0.0, 0.13, 48)) {
    drive.push_back({scan_in_room(pose, stamp, room), Pose2{}, pose});
    stamp += kScanPeriodS;
  }
  return drive;
}

/// A robot's drive: its true poses, and its scans with an odometry that begins at zero.
struct RobotDrive {
  std::vector<Pose2> T_map_base_link;
  std::vector<RobotScan> scans;
};

[[nodiscard]] inline RobotDrive robot_drive(std::size_t count = 30, double begin_rad = 2.0,
                                            const SceneBuilder& room = figure7_room()) {
  RobotDrive drive{circle_in_room(1.6, begin_rad, 0.1, count), {}};
  const Pose2 T_odom_map = inverse(drive.T_map_base_link.front());
  double stamp = 500.0;
  for (const Pose2& pose : drive.T_map_base_link) {
    drive.scans.push_back({scan_in_room(pose, stamp, room), Pose2{}, T_odom_map * pose});
    stamp += kScanPeriodS;
  }
  return drive;
}

}  // namespace cornerfix::testing

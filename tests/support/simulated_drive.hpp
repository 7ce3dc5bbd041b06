/// \file  Drives through scenes: where a robot goes, and what its lidar and odometry say on the
/// way.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>

#include "support/scan_simulator.hpp"
#include "support/scene_builder.hpp"

namespace cornerfix::testing {

struct Robot {
  Lidar lidar{.beams = 240, .noise_m = 0.01};
  Pose2 T_base_link_laser{};
  bool has_odometry = true;
  double odometry_scale = 1.0;  ///< Metres and radians reported per one that was driven.
};

/// A scan with the pose it was taken at.
struct Moment {
  RobotScan scan;
  Pose2 T_map_base_link;
};

/// Straight from point to point, a pose every `step_m`, turning on the spot by `turn_rad` at most.
[[nodiscard]] inline std::vector<Pose2> route(std::span<const Point2> points, double step_m = 0.4,
                                              double turn_rad = 0.35) {
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Point2 way = points[i + 1] - points[i];
    const double heading = std::atan2(way.y(), way.x());
    if (!poses.empty()) {
      const double turn = wrap_angle(heading - poses.back().yaw);
      const int turns = static_cast<int>(std::ceil(std::abs(turn) / turn_rad));
      const Pose2 corner = poses.back();
      for (int k = 1; k < turns; ++k) {
        poses.push_back({corner.x, corner.y, wrap_angle(corner.yaw + turn * k / turns)});
      }
    }
    const int steps = std::max(1, static_cast<int>(std::lround(way.norm() / step_m)));
    for (int k = 0; k < steps; ++k) {
      const Point2 p = points[i] + way * (static_cast<double>(k) / steps);
      poses.push_back({p.x(), p.y(), heading});
    }
  }
  return poses;
}

/// Metres to the nearest wall in any of 24 directions.
[[nodiscard]] inline double clearance(const SceneBuilder& scene, const Point2& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 24; ++i)
    nearest = std::min(nearest, scene.range(p, i * std::numbers::pi / 12));
  return nearest;
}

/// Drives ahead where there is room and turns left where there is none.
[[nodiscard]] inline std::vector<Pose2> wander(const SceneBuilder& scene, Pose2 pose,
                                               std::size_t count) {
  std::vector<Pose2> poses;
  while (poses.size() < count) {
    poses.push_back(pose);
    const bool ahead_is_free = std::ranges::all_of(
        std::vector{-0.5, -0.25, 0.0, 0.25, 0.5},
        [&](double bearing) { return scene.range(pose.translation(), pose.yaw + bearing) > 0.8; });
    pose = pose * (ahead_is_free ? Pose2{0.25, 0.0, 0.03} : Pose2{0.0, 0.0, 0.15});
  }
  return poses;
}

/// What `robot` posts from these poses, five times a second from `first_stamp` on.
[[nodiscard]] inline std::vector<Moment> drive(const SceneBuilder& scene, const Robot& robot,
                                               std::span<const Pose2> poses, std::uint64_t seed,
                                               double first_stamp = 1.0) {
  std::mt19937_64 random(seed);
  std::vector<Moment> moments;
  Pose2 T_odom_base_link{3.0, -2.0, 1.0};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i > 0) {
      Pose2 motion = inverse(poses[i - 1]) * poses[i];
      motion = {robot.odometry_scale * motion.x, robot.odometry_scale * motion.y,
                robot.odometry_scale * motion.yaw};
      T_odom_base_link = T_odom_base_link * motion;
    }
    LaserScan scan = simulate_scan(scene, robot.lidar, poses[i] * robot.T_base_link_laser, random);
    scan.stamp = first_stamp + 0.2 * static_cast<double>(i);
    RobotScan robot_scan{std::move(scan), robot.T_base_link_laser, {}};
    if (robot.has_odometry) robot_scan.T_odom_base_link = T_odom_base_link;
    moments.push_back({std::move(robot_scan), poses[i]});
  }
  return moments;
}

}  // namespace cornerfix::testing

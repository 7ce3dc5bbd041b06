#include "core/src/assessment/simulated_run.hpp"

#include <cmath>
#include <numbers>
#include <optional>

namespace cornerfix {
namespace {

constexpr double kStep = 0.5;             // [m]
constexpr double kDriveClearance = 0.25;  // of the robot's middle from walls [m]
constexpr double kRoomToTurnTo = 1.5;     // [m]
constexpr double kTurnStep = std::numbers::pi / 6.0;

/// Whether a robot gets `way_m` far ahead.
bool is_free_ahead(const SimulatedLidar& lidar, const Pose2& pose, double way_m) {
  constexpr double kCheckStep = 0.25;  // [m]
  for (double way = kCheckStep; way <= way_m; way += kCheckStep) {
    if (lidar.clearance(pose * Point2(way, 0.0)) < kDriveClearance) return false;
  }
  return true;
}

/// The smallest turn after which there is room, to the left before to the right.
std::optional<double> turn_to_room(const SimulatedLidar& lidar, const Pose2& pose, double room_m) {
  for (int steps = 1; steps <= 6; ++steps) {
    for (const double turn : {steps * kTurnStep, -steps * kTurnStep}) {
      if (is_free_ahead(lidar, pose * Pose2{0.0, 0.0, turn}, room_m)) return turn;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<Pose2> simulated_run(const SimulatedLidar& lidar, const Pose2& T_map_base_link,
                                 double way_m) {
  std::vector<Pose2> poses{T_map_base_link};
  for (double way = 0.0; way + kStep <= way_m;) {
    if (is_free_ahead(lidar, poses.back(), kStep)) {
      poses.push_back(poses.back() * Pose2{kStep, 0.0, 0.0});
      way += kStep;
      continue;
    }
    auto turn = turn_to_room(lidar, poses.back(), kRoomToTurnTo);
    if (!turn) turn = turn_to_room(lidar, poses.back(), kStep);
    if (!turn) break;
    const int steps = static_cast<int>(std::lround(std::abs(*turn) / kTurnStep));
    for (int i = 0; i < steps; ++i)
      poses.push_back(poses.back() * Pose2{0.0, 0.0, std::copysign(kTurnStep, *turn)});
  }
  return poses;
}

}  // namespace cornerfix

/// \file  A robot's motion by odometry, and whether it is enough to use the scan.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix::bench {

/// T_before_now from one odometry pose to the next; none where either is missing.
[[nodiscard]] inline Pose2 motion_between(const std::optional<Pose2>& before,
                                          const std::optional<Pose2>& now) {
  return before && now ? inverse(*before) * *now : Pose2{};
}

/// Where the beams ended, in base_link [m], in beam order; longer returns than `max_range_m` are
/// left out.
[[nodiscard]] inline std::vector<Point2> ends_in_base_link(const RobotScan& scan,
                                                           double max_range_m = 30.0) {
  std::vector<Point2> ends;
  for (const Point2& end_laser : returns_as_points(scan.scan)) {
    if (end_laser.squaredNorm() <= max_range_m * max_range_m) {
      ends.emplace_back(scan.T_base_link_laser * end_laser);
    }
  }
  return ends;
}

/// Opens at the first scan and whenever the robot has moved enough since it last did. Without
/// odometry it is always open.
class MotionFilter {
 public:
  MotionFilter(double distance_m, double angle_rad)
      : distance_m_(distance_m), angle_rad_(angle_rad) {}

  [[nodiscard]] bool opens(const std::optional<Pose2>& T_odom_base_link) {
    if (last_ && T_odom_base_link) {
      const Pose2 motion = inverse(*last_) * *T_odom_base_link;
      if (std::hypot(motion.x, motion.y) < distance_m_ && std::abs(motion.yaw) < angle_rad_)
        return false;
    }
    last_ = T_odom_base_link;
    return true;
  }

 private:
  double distance_m_;
  double angle_rad_;
  std::optional<Pose2> last_;
};

}  // namespace cornerfix::bench

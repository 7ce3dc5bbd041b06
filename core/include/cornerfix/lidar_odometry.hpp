/// \file  A robot's motion from its scans: each is laid on what the scans of the last metres saw,
/// starting from wheel odometry or, without it, from constant velocity.
///
/// The poses drift as the way grows; trajectory_optimizer.hpp takes the drift away.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/pose2.hpp>
#include <cornerfix/submap.hpp>

namespace cornerfix {

/// Deterministic. Value type; not synchronised. Memory does not grow with the way.
class LidarOdometry {
 public:
  LidarOdometry();

  /// Pose at `scan`, in the frame of base_link at the first scan. Scans come in the order in which
  /// they were taken. Where scans do not match what was seen before, odometry (or the last motion)
  /// alone leads on. O(beams).
  [[nodiscard]] Pose2 process(const RobotScan& scan);

  /// Goes on after the scans of `track`, whose poses it gave earlier: as it would have after them,
  /// but that the next scan's odometry tells no motion yet.
  void resume(std::span<const PosedScan> track);

 private:
  [[nodiscard]] RefinedPose match(const std::vector<Point2>& points,
                                  const std::optional<Pose2>& odometry) const;
  void keep(const LaserScan& scan, const Pose2& T_base_link_laser);

  Submap submap_;
  Pose2 T_submap_base_link_;
  Pose2 last_motion_;
  std::optional<Pose2> last_T_odom_base_link_;
  int stray_scans_ = 0;
};

}  // namespace cornerfix

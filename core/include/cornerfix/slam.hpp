/// \file  Maps without known poses: lidar odometry, and an optimizer that removes its drift.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/pose2.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

/// Estimates a robot's motion from its scans. Each scan is matched to the scans of the last metres,
/// starting from wheel odometry or, without it, from constant velocity. The poses drift as the path
/// grows. Deterministic. Movable; not synchronised. Memory does not grow with the path.
class LidarOdometry {
 public:
  LidarOdometry();
  ~LidarOdometry();
  LidarOdometry(LidarOdometry&&) noexcept;
  LidarOdometry& operator=(LidarOdometry&&) noexcept;

  /// Pose at `scan`, in the frame of base_link at the first scan. Scans come in the order in which
  /// they were taken. Where scans do not match what was seen before, odometry (or the last motion)
  /// alone leads on. A scan with angles or a mount of NaN has no return. O(beams).
  [[nodiscard]] Pose2 process(const RobotScan& scan);

  /// Continues after the scans of `track`, whose poses it gave earlier, as it would have after
  /// them. Only the motion of the next scan's odometry is not known yet.
  void resume(std::span<const PosedScan> track);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct OptimizedTrajectory {
  std::vector<Pose2> T_map_base_link;  ///< One a keyframe; the first is the identity.
  std::size_t submaps = 0;
  std::size_t loop_closures = 0;  ///< Submaps that were found among older ones.
};

/// Removes the drift of a mapping run: finds loop closures, verifies them, and spreads their
/// correction over all poses.
///
/// The run is cut into overlapping rigid submaps. Each is looked for among the older ones by the
/// branch-and-bound search that localizes robots, and accepted by the same test. Then every
/// keyframe is matched to every submap around it, and a pose graph over keyframes and submaps finds
/// the poses that agree best. After Hess et al. 2016.
///
/// \param drive     Keyframes at the poses of lidar odometry, in the order of driving.
/// \param progress  Called with the share done, in [0, 1]; may be empty. The work is given up when
///                  it returns false.
/// \return kInternal when the pose graph has no solution, kUnavailable when it was given up.
///
/// Deterministic, keeps no state. O(submaps * area of the map + keyframes * beams).
[[nodiscard]] Result<OptimizedTrajectory> optimize_trajectory(
    std::span<const PosedScan> drive, const std::function<bool(double)>& progress = {});

}  // namespace cornerfix

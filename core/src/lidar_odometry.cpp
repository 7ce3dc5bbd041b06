#include <cornerfix/lidar_odometry.hpp>

#include <cmath>
#include <vector>

#include "scan_motion.hpp"

namespace cornerfix {
namespace {

// How far off a predicted motion may be: wheels slip, and their messages come late.
constexpr double kLeastShift = 0.3;  // [m]
constexpr double kLeastTurn = 0.2;   // [rad]
constexpr double kShare = 0.5;       // of the motion
constexpr double kFarthest = 10.0;  // No robot moves so far in a scan: its odometry began anew [m].
constexpr double kClearlyBetter =
    0.05;  // by which constant velocity must beat it [share of points]

SearchWindow window_about(const Pose2& motion) {
  return {kLeastShift + kShare * std::hypot(motion.x, motion.y),
          kLeastTurn + kShare * std::abs(motion.yaw)};
}

}  // namespace

LidarOdometry::LidarOdometry() = default;

Pose2 LidarOdometry::process(const RobotScan& scan) {
  const std::vector<Point2> points = points_to_match(scan.scan, scan.T_base_link_laser);
  std::optional<Pose2> odometry;
  if (scan.T_odom_base_link && last_T_odom_base_link_)
    odometry = inverse(*last_T_odom_base_link_) * *scan.T_odom_base_link;
  if (odometry && odometry->translation().norm() > kFarthest) odometry.reset();
  last_T_odom_base_link_ = scan.T_odom_base_link;
  Pose2 now_at = T_submap_base_link_ * odometry.value_or(last_motion_);
  if (!points.empty() && !submap_.empty()) {
    const RefinedPose matched = match(points, odometry);
    if (matched.inlier_share >= kMinMatchedShare) {
      now_at = matched.T_frame_base_link;
      stray_scans_ = 0;
    } else if (++stray_scans_ >= kMaxStrayScans) {
      submap_ = Submap();  // its walls would only draw the next scans away
      stray_scans_ = 0;
    }
  }
  last_motion_ = inverse(T_submap_base_link_) * now_at;
  T_submap_base_link_ = now_at;
  if (!points.empty() && submap_.wants(now_at)) keep(scan.scan, scan.T_base_link_laser);
  return now_at;
}

RefinedPose LidarOdometry::match(const std::vector<Point2>& points,
                                 const std::optional<Pose2>& odometry) const {
  const auto about = [&](const Pose2& motion, bool is_odometry) {
    const PosePrior prior = is_odometry ? odometry_prior(T_submap_base_link_, motion)
                                        : constant_velocity_prior(T_submap_base_link_, motion);
    const FoundStart start = submap_.search(points, prior.T_frame_base_link, window_about(motion));
    return submap_.match(points, prior, start.T_submap_base_link);
  };
  if (!odometry) return about(last_motion_, false);
  const RefinedPose by_odometry = about(*odometry, true);
  const RefinedPose steady = about(last_motion_, false);
  return steady.inlier_share > by_odometry.inlier_share + kClearlyBetter ? steady : by_odometry;
}

void LidarOdometry::keep(const LaserScan& scan, const Pose2& T_base_link_laser) {
  submap_.keep({0, scan, T_base_link_laser, T_submap_base_link_}, {});
}

void LidarOdometry::resume(std::span<const PosedScan> track) {
  *this = LidarOdometry();
  // What lies farther back than the submap reaches is forgotten anyway.
  double way_m = 0.0;
  std::size_t first = track.size();
  for (; first > 0 && way_m <= SubmapParams{}.window_m; --first) {
    if (first < track.size())
      way_m += distance(track[first - 1].T_map_base_link, track[first].T_map_base_link);
  }
  for (const PosedScan& scan : track.subspan(first)) {
    T_submap_base_link_ = scan.T_map_base_link;
    if (submap_.wants(T_submap_base_link_)) keep(scan.scan, scan.T_base_link_laser);
  }
}

}  // namespace cornerfix

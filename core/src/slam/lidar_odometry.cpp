#include <cornerfix/slam.hpp>

#include <cmath>
#include <optional>
#include <vector>

#include "core/src/local_map/scan_motion.hpp"
#include "core/src/local_map/submap.hpp"
#include "core/src/scan/finite_scan.hpp"

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

struct LidarOdometry::Impl {
  [[nodiscard]] Pose2 process(const RobotScan& scan);
  void resume(std::span<const PosedScan> track);
  [[nodiscard]] RefinedPose match(const std::vector<Point2>& points,
                                  const std::optional<Pose2>& odometry) const;
  void keep(const LaserScan& scan, const Pose2& T_base_link_laser);

  Submap submap;
  Pose2 T_submap_base_link;
  Pose2 last_motion;
  std::optional<Pose2> last_T_odom_base_link;
  int stray_scans = 0;
};

LidarOdometry::LidarOdometry() : impl_(std::make_unique<Impl>()) {}
LidarOdometry::~LidarOdometry() = default;
LidarOdometry::LidarOdometry(LidarOdometry&&) noexcept = default;
LidarOdometry& LidarOdometry::operator=(LidarOdometry&&) noexcept = default;

Pose2 LidarOdometry::process(const RobotScan& scan) {
  const bool is_finite = has_finite_geometry(scan.scan, scan.T_base_link_laser);
  return impl_->process(is_finite ? scan : without_returns(scan));
}

void LidarOdometry::resume(std::span<const PosedScan> track) { impl_->resume(track); }

Pose2 LidarOdometry::Impl::process(const RobotScan& scan) {
  const std::vector<Point2> points = points_to_match(scan.scan, scan.T_base_link_laser);
  std::optional<Pose2> odometry;
  if (scan.T_odom_base_link && last_T_odom_base_link)
    odometry = inverse(*last_T_odom_base_link) * *scan.T_odom_base_link;
  if (odometry && odometry->translation().norm() > kFarthest) odometry.reset();
  last_T_odom_base_link = scan.T_odom_base_link;
  Pose2 now_at = T_submap_base_link * odometry.value_or(last_motion);
  if (!points.empty() && !submap.empty()) {
    const RefinedPose matched = match(points, odometry);
    if (matched.inlier_share >= kMinMatchedShare) {
      now_at = matched.T_frame_base_link;
      stray_scans = 0;
    } else if (++stray_scans >= kMaxStrayScans) {
      submap = Submap();  // its walls would only draw the next scans away
      stray_scans = 0;
    }
  }
  last_motion = inverse(T_submap_base_link) * now_at;
  T_submap_base_link = now_at;
  if (!points.empty() && submap.wants(now_at, scan.T_base_link_laser))
    keep(scan.scan, scan.T_base_link_laser);
  return now_at;
}

RefinedPose LidarOdometry::Impl::match(const std::vector<Point2>& points,
                                       const std::optional<Pose2>& odometry) const {
  const auto about = [&](const Pose2& motion, bool is_odometry) {
    const PosePrior prior = is_odometry ? odometry_prior(T_submap_base_link, motion)
                                        : constant_velocity_prior(T_submap_base_link, motion);
    const FoundStart start = submap.search(points, prior.T_frame_base_link, window_about(motion));
    return submap.match(points, prior, start.T_submap_base_link);
  };
  if (!odometry) return about(last_motion, false);
  const RefinedPose by_odometry = about(*odometry, true);
  const RefinedPose steady = about(last_motion, false);
  return steady.inlier_share > by_odometry.inlier_share + kClearlyBetter ? steady : by_odometry;
}

void LidarOdometry::Impl::keep(const LaserScan& scan, const Pose2& T_base_link_laser) {
  submap.keep({0, scan, T_base_link_laser, T_submap_base_link}, {});
}

void LidarOdometry::Impl::resume(std::span<const PosedScan> track) {
  *this = Impl();
  // What lies farther back than the submap reaches is forgotten anyway.
  double way_m = 0.0;
  std::size_t first = track.size();
  for (; first > 0 && way_m <= SubmapParams{}.window_m; --first) {
    if (first < track.size())
      way_m += distance(track[first - 1].T_map_base_link, track[first].T_map_base_link);
  }
  for (const PosedScan& scan : track.subspan(first)) {
    T_submap_base_link = scan.T_map_base_link;
    if (submap.wants(T_submap_base_link, scan.T_base_link_laser))
      keep(scan.scan, scan.T_base_link_laser);
  }
}

}  // namespace cornerfix

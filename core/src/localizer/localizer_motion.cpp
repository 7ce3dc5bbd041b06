#include "core/src/localizer/localizer_impl.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace cornerfix {
namespace {

// Matching a scan to the submap.
constexpr double kMinUsualShare = 0.6;  // a scan that matches so much worse than usual strays
constexpr double kUsualGain = 0.1;      // by which a scan changes what is usual

// By which a match from constant velocity must beat that from odometry [share of the points].
constexpr double kClearlyBetterShare = 0.05;
constexpr std::size_t kEnoughPoints = 30;  // of a scan that may overrule odometry

// Scans that were lost make an interval this many times longer; more are a pause.
constexpr double kMaxIntervalRatio = 3.0;
// Longest interval between scans without odometry: beyond it the robot may have moved farther than
// a match can find.
constexpr double kMaxUnobserved = 1.5;  // [s]
// A slower robot may stand. When odometry does not change and the robot was faster, it may hang.
constexpr double kLeastSpeed = 0.1;      // [m/s]
constexpr double kLeastTurnSpeed = 0.1;  // [rad/s]
// Odometry that differs from constant velocity by more has jumped: no wheeled robot accelerates so.
constexpr double kJump = 0.6;               // [m]
constexpr double kAcceleration = 5.0;       // [m/s^2]
constexpr double kTurnJump = 0.8;           // [rad]
constexpr double kTurnAcceleration = 20.0;  // [rad/s^2]

constexpr std::size_t kMaxLasers = 16;  // whose last scans are remembered

/// Rotates a matrix of x, y, yaw from the axes of the submap to those of base_link.
Eigen::Matrix3d in_base_link(const Eigen::Matrix3d& matrix, double yaw) {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(yaw).toRotationMatrix();
  return rotation.transpose() * matrix * rotation;
}

/// The part of a drift that a match leaves: all of it in directions that the scan does not
/// constrain. `prior` and `match` are the information of both. `match` is along the axes of
/// base_link, the others along those of the submap.
Eigen::Matrix3d drift_after_match(const Eigen::Matrix3d& drift, const Eigen::Matrix3d& prior,
                                  const Eigen::Matrix3d& match, double yaw) {
  const Eigen::Matrix3d left = (prior + in_base_link(match, -yaw)).inverse() * prior;
  return left * drift * left.transpose();
}

bool is_jump(const Pose2& odometry, const Pose2& steady_motion, double interval_s) {
  const double squared_s = interval_s * interval_s;
  return distance(odometry, steady_motion) > kJump + kAcceleration * squared_s ||
         angle_between(odometry, steady_motion) > kTurnJump + kTurnAcceleration * squared_s;
}

bool is_moving(const Pose2& motion, double interval_s) {
  return motion.translation().norm() > kLeastSpeed * interval_s ||
         std::abs(motion.yaw) > kLeastTurnSpeed * interval_s;
}

}  // namespace

void Localizer::Impl::move_along(const RobotScan& robot_scan, const std::vector<Point2>& points) {
  const Pose2 before = T_submap_base_link;
  const double stamp_before = last_stamp.value_or(robot_scan.scan.stamp);
  const Prediction prediction = predict(robot_scan);
  const Pose2& T_base_link_laser = robot_scan.T_base_link_laser;
  const LaserMoment last_moment{T_base_link_laser, stamp_before, before};
  // This scan begins the submap, wherever it is.
  if (submap.empty()) return note_velocity(last_moment);
  const bool has_odometry = prediction.odometry && odometry_monitor.use() != OdometryUse::kIgnored;
  const bool is_unobserved = !has_odometry && robot_scan.scan.stamp - stamp_before > kMaxUnobserved;
  if (accepted && is_unobserved) {
    restart_submap(Withdrawal::kScansLost);
    return;
  }
  Pose2 now_at = prediction.likely.prior.T_frame_base_link;
  Eigen::Matrix3d noise = prediction.likely.drift;
  if (!points.empty()) {
    const Match matched = match(points, prediction);
    const bool is_new_laser = !submap.knows_laser(T_base_link_laser);
    if (belongs_to_submap(matched.pose.inlier_share, is_new_laser)) {
      now_at = matched.pose.T_frame_base_link;
      stray_scans = 0;
      const Eigen::Matrix3d information = submap.match_information(points, now_at);
      noise = drift_after_match(matched.from.drift, matched.from.prior.information, information,
                                now_at.yaw);
      if (prediction.odometry)
        odometry_monitor.add(*prediction.odometry, inverse(before) * now_at, information);
    } else if (!is_new_laser && ++stray_scans >= kMaxStrayScans) {
      restart_submap(Withdrawal::kScansLost);
      return;
    }
  }
  T_submap_base_link = now_at;
  note_velocity(last_moment);
  const Pose2 motion = inverse(before) * now_at;
  const double step = distance(before, now_at);
  search.move_along(motion);
  if (accepted) {
    misfit_way_m += step;
    distance_since_acceptance_m += step;
    tracker.predict(motion, in_base_link(noise, now_at.yaw));
  }
}

Localizer::Impl::Prediction Localizer::Impl::predict(const RobotScan& robot_scan) {
  const std::optional<Pose2> T_odom_before =
      std::exchange(last_T_odom_base_link, robot_scan.T_odom_base_link);
  const double interval_s = last_stamp ? robot_scan.scan.stamp - *last_stamp : 0.0;
  const Pose2 steady_motion = motion_at_constant_velocity(interval_s);
  last_stamp = robot_scan.scan.stamp;
  const PosePrior steady_prior = constant_velocity_prior(T_submap_base_link, steady_motion);
  const PredictedPose steady{steady_prior, steady_prior.information.inverse()};
  if (!T_odom_before || !last_T_odom_base_link) return {steady, {}, false, {}};

  const Pose2 odometry = inverse(*T_odom_before) * *last_T_odom_base_link;
  if (odometry_monitor.use() == OdometryUse::kIgnored) return {steady, {}, false, odometry};
  const bool is_unchanged = *T_odom_before == *last_T_odom_base_link;
  if (is_unchanged && !is_moving(steady_motion, interval_s)) {
    const PredictedPose standing{standing_prior(T_submap_base_link, odometry_monitor.noise_scale()),
                                 Eigen::Matrix3d::Zero()};
    return {standing, {}, true, odometry};
  }
  const PredictedPose by_odometry = predict_by_odometry(odometry);
  if (is_unchanged || is_jump(odometry, steady_motion, interval_s))
    return {steady, by_odometry, false, odometry};
  return {by_odometry, steady, true, odometry};
}

Localizer::Impl::PredictedPose Localizer::Impl::predict_by_odometry(const Pose2& motion) const {
  const Eigen::Vector3d scale = odometry_monitor.noise_scale();
  const PosePrior prior = odometry_prior(T_submap_base_link, motion, scale);
  const Eigen::Matrix3d drift = odometry_drift(motion).cwiseProduct(scale.cwiseAbs2()).asDiagonal();
  return {prior, in_base_link(drift, -prior.T_frame_base_link.yaw)};
}

Pose2 Localizer::Impl::motion_at_constant_velocity(double interval_s) const {
  if (last_interval_s <= 0.0) return last_motion;
  const double ratio = std::min(kMaxIntervalRatio, interval_s / last_interval_s);
  return {ratio * last_motion.x, ratio * last_motion.y, wrap_angle(ratio * last_motion.yaw)};
}

Localizer::Impl::Match Localizer::Impl::match(const std::vector<Point2>& points,
                                              const Prediction& prediction) const {
  const Match likely{submap.match(points, prediction.likely.prior), prediction.likely};
  const bool is_enough =
      prediction.is_odometry_likely && likely.pose.inlier_share >= least_matched_share();
  if (is_enough || !prediction.alternative || points.size() < kEnoughPoints) return likely;
  const Match other{submap.match(points, prediction.alternative->prior), *prediction.alternative};
  return other.pose.inlier_share > likely.pose.inlier_share + kClearlyBetterShare ? other : likely;
}

double Localizer::Impl::least_matched_share() const {
  return std::max(kMinMatchedShare, kMinUsualShare * usual_share.value_or(0.0));
}

void Localizer::Impl::note_velocity(LaserMoment last_moment) {
  const auto known = std::ranges::find_if(lasers, [&](const LaserMoment& one) {
    return is_same_laser(one.T_base_link_laser, last_moment.T_base_link_laser);
  });
  if (known != lasers.end()) {
    last_moment = *known;
    lasers.erase(known);
  }
  const double interval_s = *last_stamp - last_moment.stamp;
  if (interval_s > 0.0) {
    last_motion = inverse(last_moment.T_submap_base_link) * T_submap_base_link;
    last_interval_s = interval_s;
  }
  if (lasers.size() == kMaxLasers) lasers.erase(lasers.begin());
  lasers.push_back({last_moment.T_base_link_laser, *last_stamp, T_submap_base_link});
}

bool Localizer::Impl::belongs_to_submap(double matched_share, bool is_new_laser) {
  // What the first scan of a laser shows, no other may have seen.
  if (is_new_laser) return matched_share >= kMinMatchedShare;
  const double usual = usual_share.value_or(matched_share);
  usual_share = usual + kUsualGain * (matched_share - usual);
  return matched_share >= std::max(kMinMatchedShare, kMinUsualShare * usual);
}

void Localizer::Impl::restart_submap(Withdrawal cause) {
  submap = Submap();
  T_submap_base_link = {};
  last_motion = {};
  lasers.clear();
  stray_scans = 0;
  usual_share.reset();
  search.reset();
  region.reset();
  new_ground = {};
  if (accepted) withdraw(cause);
  terms = {};
  confidence = 0.0;
}

}  // namespace cornerfix

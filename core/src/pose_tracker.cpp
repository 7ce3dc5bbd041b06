#include "pose_tracker.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <cornerfix/evidence_model.hpp>
#include <cornerfix/scan_refiner.hpp>

namespace cornerfix {
namespace {

// Of the pose at the moment of the fix.
constexpr double kFixSigmaPosition = 0.05;
constexpr double kFixSigmaYaw = 0.02;
// Drift of the submap: standard deviations after a metre, which grow with the square root of the
// way; and errors of odometry where scan matching does not confirm it, as a share of the way.
constexpr double kDriftPosition = 0.03;
constexpr double kDriftYaw = 0.01;
constexpr double kDriftYawOfTurn = 0.01;  // after a radian
constexpr double kOdometryError = 0.1;
// The map corrects the pose with points whose errors are alike along a wall: each counts for
// little.
constexpr ScanRefinerParams kCorrection{
    .kernel_m = 0.15, .sigma_point_m = 0.3, .max_iterations = 8};
constexpr double kApproach = 0.3;   // from here on a beam must have come through mapped space [m]
constexpr double kMinKnown = 0.25;  // share of ends that the map must know to correct the pose
constexpr double kMinFitShare = 0.35;
constexpr double kMaxContradictedShare = 0.4;
constexpr double kMinUsualFit = 0.6;   // of what fits otherwise
constexpr double kUsualFitGain = 0.1;  // by which a scan changes what is usual
// What the map itself may be off by.
const Eigen::Vector3d kMapVariance{4e-4, 4e-4, 1e-5};

double squared(double value) { return value * value; }

/// Ends that beams reached through space that the map knows. A wall known from its other side only
/// is another wall.
std::vector<Point2> ends_on_known_ground(const ClassField& classes, std::span<const Point2> points,
                                         const Point2& laser, const Pose2& T_map_base_link) {
  const Pose2 T_grid_base_link = classes.T_grid_map() * T_map_base_link;
  const double scale = 1.0 / classes.resolution();
  std::vector<Point2> known;
  known.reserve(points.size());
  for (const Point2& end : points) {
    const double range = (end - laser).norm();
    const Point2 before = end - (end - laser) * std::min(1.0, kApproach / std::max(range, 1e-6));
    const Point2 cell = (T_grid_base_link * before) * scale;
    const auto pass = static_cast<PassClass>(classes.pass_class(
        static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y()))));
    if (pass != PassClass::kUnknown) known.push_back(end);
  }
  return known;
}

}  // namespace

PoseTracker::PoseTracker(const Pose2& T_map_base_link)
    : T_map_base_link_(T_map_base_link),
      covariance_(Eigen::Vector3d{squared(kFixSigmaPosition), squared(kFixSigmaPosition),
                                  squared(kFixSigmaYaw)}
                      .asDiagonal()) {}

PoseTracker::PoseTracker(const Pose2& T_map_base_link, Eigen::Matrix3d filtered_covariance,
                         std::optional<double> usual_fit)
    : T_map_base_link_(T_map_base_link),
      covariance_(std::move(filtered_covariance)),
      usual_fit_(usual_fit) {}

void PoseTracker::predict(const Pose2& motion, bool matched) {
  const Pose2 before = T_map_base_link_;
  T_map_base_link_ = before * motion;
  Eigen::Matrix3d transition = Eigen::Matrix3d::Identity();
  transition(0, 2) = before.y - T_map_base_link_.y;
  transition(1, 2) = T_map_base_link_.x - before.x;
  covariance_ = transition * covariance_ * transition.transpose();
  const double way = std::hypot(motion.x, motion.y);
  const double turn = std::abs(motion.yaw);
  double position = squared(kDriftPosition) * way;
  double yaw = squared(kDriftYaw) * way + squared(kDriftYawOfTurn) * turn;
  if (!matched) {
    position += squared(kOdometryError * way);
    yaw += squared(kOdometryError * turn);
  }
  covariance_.diagonal() += Eigen::Vector3d{position, position, yaw};
}

TrackingVerdict PoseTracker::update(const LocalizationMap& map, std::span<const Point2> points,
                                    const Point2& laser) {
  if (points.empty()) return TrackingVerdict::kNoReturns;
  const std::vector<Point2> known =
      ends_on_known_ground(map.classes(), points, laser, T_map_base_link_);
  const double known_share = static_cast<double>(known.size()) / static_cast<double>(points.size());
  const PosePrior prior{T_map_base_link_, covariance_.inverse()};
  const RefinedPose refined = refine_pose(map.field(), known, T_map_base_link_, kCorrection, prior);
  const EvidenceScore fit = score_evidence(map.classes(), {known, {}}, refined.T_frame_base_link);
  if (known_share >= kMinKnown && fit.matched >= kMinFitShare) {
    T_map_base_link_ = refined.T_frame_base_link;
    covariance_ = (prior.information +
                   observed_information(map.field(), known, T_map_base_link_, kCorrection))
                      .inverse();
  }
  const double matched_of_mapped = fit.matched / std::max(0.2, 1.0 - fit.unmapped);
  const double usual = usual_fit_.value_or(matched_of_mapped);
  if (fit.matched * known_share < kMinFitShare || fit.contradicted > kMaxContradictedShare ||
      matched_of_mapped < kMinUsualFit * usual)
    return TrackingVerdict::kMisfits;
  usual_fit_ = usual + kUsualFitGain * (matched_of_mapped - usual);
  return TrackingVerdict::kFits;
}

Eigen::Matrix3d PoseTracker::covariance() const {
  Eigen::Matrix3d covariance = covariance_;
  covariance.diagonal() += kMapVariance;
  return covariance;
}

}  // namespace cornerfix

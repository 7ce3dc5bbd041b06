#include "core/src/tracking/pose_tracker.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/src/base/thinned.hpp"
#include "core/src/map/evidence_model.hpp"
#include "core/src/matching/scan_refiner.hpp"
#include "core/src/search/map_index.hpp"

namespace cornerfix {
namespace {

// Of the pose at its acceptance.
constexpr double kFixSigmaPosition = 0.05;
constexpr double kFixSigmaYaw = 0.02;
// Drift of the submap: standard deviations after a metre, which grow with the square root of the
// way.
constexpr double kDriftPosition = 0.03;
constexpr double kDriftYaw = 0.01;
constexpr double kDriftYawOfTurn = 0.01;  // after a radian
// The map corrects the pose with points whose errors are alike along a wall: each counts for
// little.
constexpr ScanRefinerParams kCorrection{
    .kernel_m = 0.15, .sigma_point_m = 0.3, .max_iterations = 8, .normal_error_rad = 0.2};
constexpr double kApproach = 0.3;   // from here on a beam must have come through mapped space [m]
constexpr double kMinKnown = 0.25;  // share of ends that the map must know to correct the pose
constexpr double kMinFitShare = 0.35;
constexpr double kMaxContradictedShare = 0.4;
constexpr double kMinUsualFit = 0.6;   // of what fits otherwise
constexpr double kUsualFitGain = 0.1;  // by which a scan changes what is usual
// What the map itself may be off by.
const Eigen::Vector3d kMapVariance{4e-4, 4e-4, 1e-5};

// Scans from one place repeat the same errors: a scan counts as a whole one after so much driving.
constexpr double kIndependentDistance = 0.25;  // [m]
constexpr double kTurnAsDistance = 0.5;        // [m/rad]
constexpr double kLeastDistance = 0.02;        // [m] a robot that stands still observes nothing new
// Where the pose is uncertain by more than the basin of a refinement, other starts are tried.
constexpr double kBasin = 0.12;         // [m]
constexpr double kStartSpacing = 0.15;  // [m]
constexpr int kMaxStarts = 10;          // to either side

double squared(double value) { return value * value; }

/// Mean squared distance of points to walls, capped [m^2].
double mean_squared_distance(const DistanceField& field, std::span<const Point2> points,
                             const Pose2& T_map_base_link) {
  constexpr double kCap = 0.3;  // [m]
  const Pose2 T = field.T_grid_frame() * T_map_base_link;
  double sum = 0.0;
  for (const Point2& p : points) sum += squared(std::min(kCap, field.nearest(T * p)));
  return sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

/// Where to start a refinement: the prediction, or the pose along its most uncertain direction
/// whose points lie clearly nearer to walls.
Pose2 best_start(const DistanceField& field, std::span<const Point2> points, const Pose2& predicted,
                 const Eigen::Matrix3d& covariance) {
  constexpr std::size_t kPoints = 90;
  constexpr double kCoarseGain = 0.8;  // of the mean squared distance
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance.topLeftCorner<2, 2>());
  const double sigma = std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
  if (!(sigma >= kBasin)) return predicted;
  const Eigen::Vector2d axis = axes.eigenvectors().col(1);
  const std::vector<Point2> some = thinned(points, kPoints);
  Pose2 best = predicted;
  double least = kCoarseGain * mean_squared_distance(field, some, predicted);
  const int starts = std::min(kMaxStarts, static_cast<int>(2.0 * sigma / kStartSpacing));
  for (int i = -starts; i <= starts; ++i) {
    const Eigen::Vector2d shift = kStartSpacing * i * axis;
    const Pose2 start{predicted.x + shift.x(), predicted.y + shift.y(), predicted.yaw};
    const double cost = mean_squared_distance(field, some, start);
    if (cost >= least) continue;
    least = cost;
    best = start;
  }
  return best;
}

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
    const auto pass = static_cast<PassClass>(classes.packed(cell) >> 4U);
    if (pass != PassClass::kUnknown) known.push_back(end);
  }
  return known;
}

/// Of evenly thinned points, each standing for its neighbours.
PointInformation information_of(const DistanceField& field, std::span<const Point2> points,
                                const Pose2& T_map_base_link, const ScanRefinerParams& params) {
  constexpr std::size_t kPoints = 90;
  const std::vector<Point2> some = thinned(points, kPoints);
  const double weight = static_cast<double>(points.size()) /
                        static_cast<double>(std::max<std::size_t>(1, some.size()));
  const PointInformation of_some = point_information(field, some, T_map_base_link, params);
  return {weight * of_some.claimed, weight * of_some.observed};
}

}  // namespace

Pose2 moved_as_observed(const PosePrior& prior, const Pose2& matched,
                        const PointInformation& information) {
  const Pose2& from = prior.T_frame_base_link;
  const Eigen::Vector3d moved{matched.x - from.x, matched.y - from.y,
                              wrap_angle(matched.yaw - from.yaw)};
  // observed = L (V diag(m) V') L' with the prior L L'.
  const Eigen::Matrix3d L = prior.information.llt().matrixL();
  const Eigen::Matrix3d to_unit = L.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(to_unit * information.observed *
                                                            to_unit.transpose());
  Eigen::Vector3d step = axes.eigenvectors().transpose() * L.transpose() * moved;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = to_unit.transpose() * axes.eigenvectors().col(i);
    const double m = std::max(0.0, axes.eigenvalues()[i]);
    const double f = std::max(m, axis.dot(information.claimed * axis));
    step[i] *= m > 0.0 ? m / (1.0 + m) * (1.0 + f) / f : 0.0;
  }
  const Eigen::Vector3d kept = to_unit.transpose() * axes.eigenvectors() * step;
  return {from.x + kept.x(), from.y + kept.y(), wrap_angle(from.yaw + kept.z())};
}

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

void PoseTracker::predict(const Pose2& motion, const Eigen::Matrix3d& noise) {
  const Pose2 before = T_map_base_link_;
  T_map_base_link_ = before * motion;
  Eigen::Matrix3d transition = Eigen::Matrix3d::Identity();
  transition(0, 2) = before.y - T_map_base_link_.y;
  transition(1, 2) = T_map_base_link_.x - before.x;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T_map_base_link_.yaw).toRotationMatrix();
  covariance_ =
      transition * covariance_ * transition.transpose() + rotation * noise * rotation.transpose();
  const double step_m = std::hypot(motion.x, motion.y);
  const double turn_rad = std::abs(motion.yaw);
  const double position = squared(kDriftPosition) * step_m;
  const double yaw = squared(kDriftYaw) * step_m + squared(kDriftYawOfTurn) * turn_rad;
  covariance_.diagonal() += Eigen::Vector3d{position, position, yaw};
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  distance_m_ += step_m + kTurnAsDistance * turn_rad;
}

TrackingVerdict PoseTracker::update(const LocalizationMap& map, std::span<const Point2> points,
                                    const Point2& laser) {
  if (points.empty()) return TrackingVerdict::kNoReturns;
  const std::vector<Point2> known =
      ends_on_known_ground(map.index().classes, points, laser, T_map_base_link_);
  const double known_share = static_cast<double>(known.size()) / static_cast<double>(points.size());
  const PosePrior prior{T_map_base_link_, covariance_.inverse()};
  const double share =
      std::clamp(std::max(distance_m_, kLeastDistance) / kIndependentDistance, 0.0, 1.0);
  ScanRefinerParams correction = kCorrection;
  correction.sigma_point_m /= std::sqrt(share);
  const Pose2 start = best_start(map.index().field, known, T_map_base_link_, covariance_);
  const Pose2 aligned = aligned_pose(map.index().field, known, start, correction, prior);
  const PointInformation information =
      information_of(map.index().field, known, aligned, correction);
  const Pose2 corrected = moved_as_observed(prior, aligned, information);
  const EvidenceScore fit = score_evidence(map.index().classes, {known, {}}, corrected);
  if (known_share >= kMinKnown && fit.matched >= kMinFitShare) {
    T_map_base_link_ = corrected;
    if (distance_m_ >= kLeastDistance) {
      covariance_ = (prior.information + information.observed).inverse();
      distance_m_ = 0.0;
    }
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

double PoseTracker::position_sigma_m() const {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance().topLeftCorner<2, 2>());
  return std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
}

}  // namespace cornerfix

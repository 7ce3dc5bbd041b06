#include "core/src/matching/scan_refiner.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace cornerfix {
namespace {

struct NormalEquations {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< Lower triangle.
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// Turns and shifts points as base_link at T does.
class Placed {
 public:
  explicit Placed(const Pose2& T) : T_(T), c_(std::cos(T.yaw)), s_(std::sin(T.yaw)) {}
  [[nodiscard]] Point2 turned(const Point2& p) const {
    return {c_ * p.x() - s_ * p.y(), s_ * p.x() + c_ * p.y()};
  }
  [[nodiscard]] Point2 shifted(const Point2& p) const { return {T_.x + p.x(), T_.y + p.y()}; }

 private:
  Pose2 T_;
  double c_;
  double s_;
};

/// Sums J^T w J and J^T w d over the points; T is base_link in frame `grid`.
NormalEquations linearize(const DistanceField& field, std::span<const Point2> points,
                          const Pose2& T, const ScanRefinerParams& params) {
  const Placed placed(T);
  const double kernel2 = params.kernel_m * params.kernel_m;
  const double point_information = 1.0 / (params.sigma_point_m * params.sigma_point_m);
  NormalEquations sum;
  for (const Point2& p : points) {
    const Point2 turned = placed.turned(p);
    const DistanceField::Sample sample = field.sample(placed.shifted(turned));
    const double d2 = sample.distance * sample.distance;
    if (d2 > 16.0 * kernel2) continue;  // its weight is under 1/289
    const double root = kernel2 / (kernel2 + d2);
    const double weight = root * root * point_information;
    const double gx = sample.gradient.x();
    const double gy = sample.gradient.y();
    const Eigen::Vector3d jacobian{gx, gy, gy * turned.x() - gx * turned.y()};
    const Eigen::Vector3d weighted = weight * jacobian;
    for (Eigen::Index column = 0; column < 3; ++column) {
      for (Eigen::Index row = column; row < 3; ++row)
        sum.information(row, column) += weighted[row] * jacobian[column];
    }
    sum.gradient.noalias() += (weight * sample.distance) * jacobian;
  }
  return sum;
}

/// Share of the points within the kernel of a wall.
double inlier_share(const DistanceField& field, std::span<const Point2> points, const Pose2& T,
                    double kernel_m) {
  const Placed placed(T);
  std::size_t inliers = 0;
  for (const Point2& p : points) {
    const double distance = field.distance(placed.shifted(placed.turned(p)));
    inliers += distance * distance <= kernel_m * kernel_m ? 1U : 0U;
  }
  return static_cast<double>(inliers) / static_cast<double>(points.size());
}

/// The slope of the field over a few cells, which the cells' edges do not disturb.
Point2 smooth_gradient(const DistanceField& field, const Point2& point_grid) {
  constexpr double kReach = 0.1;
  const auto distance = [&](double dx, double dy) {
    return field.distance(point_grid + Point2{dx, dy});
  };
  return Point2{distance(kReach, 0.0) - distance(-kReach, 0.0),
                distance(0.0, kReach) - distance(0.0, -kReach)} /
         (2.0 * kReach);
}

void add_prior(NormalEquations& sum, const Pose2& T, const PosePrior& prior) {
  const Pose2& at = prior.T_frame_base_link;
  const Eigen::Vector3d offset{T.x - at.x, T.y - at.y, wrap_angle(T.yaw - at.yaw)};
  sum.information += prior.information;
  sum.gradient += prior.information * offset;
}

/// Takes an information matrix of x, y, yaw to the axes of a frame turned by `yaw` against its own.
Eigen::Matrix3d turned(const Eigen::Matrix3d& information, double yaw) {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  rotation.topLeftCorner<2, 2>() << c, -s, s, c;
  return rotation * information * rotation.transpose();
}

}  // namespace

PosePrior isotropic_prior(const Pose2& T_frame_base_link, double sigma_position_m,
                          double sigma_yaw_rad) {
  const double position = 1.0 / (sigma_position_m * sigma_position_m);
  const double yaw = 1.0 / (sigma_yaw_rad * sigma_yaw_rad);
  return {T_frame_base_link, Eigen::Vector3d{position, position, yaw}.asDiagonal()};
}

RefinedPose refine_pose(const DistanceField& field, std::span<const Point2> points_base_link,
                        const Pose2& T_frame_base_link, const ScanRefinerParams& params,
                        const std::optional<PosePrior>& prior) {
  RefinedPose result{.T_frame_base_link = T_frame_base_link};
  if (points_base_link.empty()) return result;
  const Pose2 T_frame_grid = inverse(field.T_grid_frame());
  Pose2 T = field.T_grid_frame() * T_frame_base_link;
  std::optional<PosePrior> prior_grid;
  if (prior) {
    prior_grid = {field.T_grid_frame() * prior->T_frame_base_link,
                  turned(prior->information, field.T_grid_frame().yaw)};
  }
  const Eigen::Matrix3d keeps_blind_directions = 1e-3 * Eigen::Matrix3d::Identity();
  for (int i = 0; i < params.max_iterations; ++i) {
    NormalEquations sum = linearize(field, points_base_link, T, params);
    add_prior(sum, T, prior_grid.value_or(PosePrior{T, keeps_blind_directions}));
    const Eigen::Vector3d step = -sum.information.ldlt().solve(sum.gradient);
    T = {T.x + step.x(), T.y + step.y(), wrap_angle(T.yaw + step.z())};
    if (std::abs(step.x()) + std::abs(step.y()) < 5e-4 && std::abs(step.z()) < 2e-4) break;
  }
  result.T_frame_base_link = T_frame_grid * T;
  result.inlier_share = inlier_share(field, points_base_link, T, params.kernel_m);
  return result;
}

/// On a wall the field has no slope, so the direction of the wall is read off a little before it,
/// where the beam came from.
Eigen::Matrix3d observed_information(const DistanceField& field,
                                     std::span<const Point2> points_base_link,
                                     const Pose2& T_frame_base_link,
                                     const ScanRefinerParams& params) {
  constexpr double kBefore = 0.25;
  const Pose2 T = field.T_grid_frame() * T_frame_base_link;
  const Placed placed(T);
  const double kernel2 = params.kernel_m * params.kernel_m;
  const double point_information = 1.0 / (params.sigma_point_m * params.sigma_point_m);
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const Point2& p : points_base_link) {
    const Point2 turned_point = placed.turned(p);
    const double distance = field.distance(placed.shifted(turned_point));
    if (distance > 2.0 * params.kernel_m) continue;
    const Point2 before =
        turned_point * std::max(0.0, 1.0 - kBefore / std::max(turned_point.norm(), kBefore));
    Point2 normal = smooth_gradient(field, placed.shifted(before));
    if (normal.squaredNorm() > 1.0) normal.normalize();
    const double root = kernel2 / (kernel2 + distance * distance);
    const Eigen::Vector3d jacobian{normal.x(), normal.y(),
                                   normal.y() * turned_point.x() - normal.x() * turned_point.y()};
    information.noalias() += (root * root * point_information) * jacobian * jacobian.transpose();
  }
  return turned(information, -field.T_grid_frame().yaw);
}

}  // namespace cornerfix

#include "core/src/matching/scan_refiner.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
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

constexpr std::size_t kBlock = 32;
using Lane = std::array<double, kBlock>;

/// Points and the field about them, a few at a time and value by value, so that the compiler can
/// use vector instructions.
struct PointBlock {
  std::size_t size = 0;
  Lane x, y;                // Turned, not shifted.
  Lane fx, fy;              // Of the place between four cell centres.
  Lane d00, d10, d01, d11;  // There, by column and row [DistanceField::kStep].
};

/// T is base_link in frame `grid`. At most kBlock points.
template <typename Field>
void look_up(const Field& field, std::span<const Point2> points, const Pose2& T,
             PointBlock& block) {
  const double c = std::cos(T.yaw);
  const double s = std::sin(T.yaw);
  const double scale = field.cells_per_metre();
  const double columns = field.width() - 1;
  const double rows = field.height() - 1;
  std::array<int, kBlock> column;
  std::array<int, kBlock> row;
  block.size = points.size();
  const double* xy = points.front().data();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = xy[2 * i];
    const double y = xy[2 * i + 1];
    block.x[i] = c * x - s * y;
    block.y[i] = s * x + c * y;
    const double u = (T.x + block.x[i]) * scale - 0.5;
    const double v = (T.y + block.y[i]) * scale - 0.5;
    const bool is_inside = (u >= 0.0) & (v >= 0.0) & (u < columns) & (v < rows);
    const double inside_u = is_inside ? u : -1.0;
    const double inside_v = is_inside ? v : -1.0;
    column[i] = static_cast<int>(inside_u);
    row[i] = static_cast<int>(inside_v);
    block.fx[i] = inside_u - column[i];
    block.fy[i] = inside_v - row[i];
  }
  constexpr std::array<std::uint8_t, 2> kFar{255, 255};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const FieldSquare square =
        column[i] >= 0 ? field.square(column[i], row[i]) : FieldSquare{&kFar[0], &kFar[0]};
    block.d00[i] = square.lower[0];
    block.d10[i] = square.lower[1];
    block.d01[i] = square.upper[0];
    block.d11[i] = square.upper[1];
  }
}

/// What each point adds to the normal equations.
struct BlockTerms {
  Lane xx, yx, rx, yy, ry, rr;  // Of the information; r is the rotation.
  Lane x, y, r;                 // Of the gradient.
};

template <typename Field>
void weigh(const Field& field, const PointBlock& block, const ScanRefinerParams& params,
           BlockTerms& terms) {
  const double kernel2 = params.kernel_m * params.kernel_m;
  const double point_information = 1.0 / (params.sigma_point_m * params.sigma_point_m);
  const double slope_scale = DistanceField::kStep * field.cells_per_metre();
  for (std::size_t i = 0; i < block.size; ++i) {
    const double slope = block.d10[i] - block.d00[i];
    const double upper_slope = block.d11[i] - block.d01[i];
    const double bottom = block.d00[i] + block.fx[i] * slope;
    const double top = block.d01[i] + block.fx[i] * upper_slope;
    const double distance = DistanceField::kStep * (bottom + block.fy[i] * (top - bottom));
    const double gx = slope_scale * (slope + block.fy[i] * (upper_slope - slope));
    const double gy = slope_scale * (top - bottom);
    const double gr = gy * block.x[i] - gx * block.y[i];
    const double d2 = distance * distance;
    const double root = kernel2 / (kernel2 + d2);
    // Farther away its weight is under 1/289.
    const double weight = d2 > 16.0 * kernel2 ? 0.0 : root * root * point_information;
    const double wx = weight * gx;
    const double wy = weight * gy;
    const double wr = weight * gr;
    const double wd = weight * distance;
    terms.xx[i] = wx * gx;
    terms.yx[i] = wy * gx;
    terms.rx[i] = wr * gx;
    terms.yy[i] = wy * gy;
    terms.ry[i] = wr * gy;
    terms.rr[i] = wr * gr;
    terms.x[i] = wd * gx;
    terms.y[i] = wd * gy;
    terms.r[i] = wd * gr;
  }
}

void add(NormalEquations& sum, const BlockTerms& terms, std::size_t size) {
  Eigen::Matrix3d& information = sum.information;
  Eigen::Vector3d& gradient = sum.gradient;
  for (std::size_t i = 0; i < size; ++i) {
    information(0, 0) += terms.xx[i];
    information(1, 0) += terms.yx[i];
    information(2, 0) += terms.rx[i];
    information(1, 1) += terms.yy[i];
    information(2, 1) += terms.ry[i];
    information(2, 2) += terms.rr[i];
    gradient[0] += terms.x[i];
    gradient[1] += terms.y[i];
    gradient[2] += terms.r[i];
  }
}

/// Sums J^T w J and J^T w d over the points; T is base_link in frame `grid`.
template <typename Field>
NormalEquations linearize(const Field& field, std::span<const Point2> points, const Pose2& T,
                          const ScanRefinerParams& params) {
  NormalEquations sum;
  PointBlock block;
  BlockTerms terms;
  for (std::size_t begin = 0; begin < points.size(); begin += kBlock) {
    look_up(field, points.subspan(begin, std::min(kBlock, points.size() - begin)), T, block);
    weigh(field, block, params, terms);
    add(sum, terms, block.size);
  }
  return sum;
}

/// Share of the points within the kernel of a wall.
template <typename Field>
double inlier_share(const Field& field, std::span<const Point2> points, const Pose2& T,
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
template <typename Field>
Point2 smooth_gradient(const Field& field, const Point2& point_grid) {
  constexpr double kReach = 0.1;
  const auto distance = [&](double dx, double dy) {
    return field.distance(point_grid + Point2{dx, dy});
  };
  return Point2{distance(kReach, 0.0) - distance(-kReach, 0.0),
                distance(0.0, kReach) - distance(0.0, -kReach)} /
         (2.0 * kReach);
}

/// How a shift along `direction` follows from x, y and yaw, at a point that the pose has turned.
Eigen::Vector3d jacobian_of(const Point2& direction, const Point2& turned_point) {
  return {direction.x(), direction.y(),
          direction.y() * turned_point.x() - direction.x() * turned_point.y()};
}

/// Without the directions whose information is negative.
Eigen::Matrix3d positive_part(const Eigen::Matrix3d& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(information);
  return axes.eigenvectors() * axes.eigenvalues().cwiseMax(0.0).asDiagonal() *
         axes.eigenvectors().transpose();
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

/// As aligned_pose(), but for the result's frame; of at least one point.
template <typename Field>
Pose2 aligned_in_grid(const Field& field, std::span<const Point2> points_base_link,
                      const Pose2& T_frame_base_link, const ScanRefinerParams& params,
                      const std::optional<PosePrior>& prior) {
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
  return T;
}

}  // namespace

PosePrior isotropic_prior(const Pose2& T_frame_base_link, double sigma_position_m,
                          double sigma_yaw_rad) {
  const double position = 1.0 / (sigma_position_m * sigma_position_m);
  const double yaw = 1.0 / (sigma_yaw_rad * sigma_yaw_rad);
  return {T_frame_base_link, Eigen::Vector3d{position, position, yaw}.asDiagonal()};
}

template <typename Field>
Pose2 aligned_pose(const Field& field, std::span<const Point2> points_base_link,
                   const Pose2& T_frame_base_link, const ScanRefinerParams& params,
                   const std::optional<PosePrior>& prior) {
  if (points_base_link.empty()) return T_frame_base_link;
  const Pose2 T_grid_base_link =
      aligned_in_grid(field, points_base_link, T_frame_base_link, params, prior);
  return inverse(field.T_grid_frame()) * T_grid_base_link;
}

template <typename Field>
RefinedPose refine_pose(const Field& field, std::span<const Point2> points_base_link,
                        const Pose2& T_frame_base_link, const ScanRefinerParams& params,
                        const std::optional<PosePrior>& prior) {
  if (points_base_link.empty()) return {.T_frame_base_link = T_frame_base_link};
  const Pose2 T_grid_base_link =
      aligned_in_grid(field, points_base_link, T_frame_base_link, params, prior);
  return {inverse(field.T_grid_frame()) * T_grid_base_link,
          inlier_share(field, points_base_link, T_grid_base_link, params.kernel_m)};
}

/// On a wall the field has no slope, so the direction of the wall is read off a little before it,
/// where the beam came from.
///
/// A normal n + s t with an error s along the wall has s^2 t t^T more information than n. Over a
/// long corridor these errors would add up to information along its axis, so they are subtracted.
template <typename Field>
PointInformation point_information(const Field& field, std::span<const Point2> points_base_link,
                                   const Pose2& T_frame_base_link,
                                   const ScanRefinerParams& params) {
  constexpr double kBefore = 0.25;  // [m]
  const Pose2 T = field.T_grid_frame() * T_frame_base_link;
  const Placed placed(T);
  const double kernel2 = params.kernel_m * params.kernel_m;
  const double of_one_point = 1.0 / (params.sigma_point_m * params.sigma_point_m);
  PointInformation information{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
  for (const Point2& p : points_base_link) {
    const Point2 turned_point = placed.turned(p);
    const double distance = field.distance(placed.shifted(turned_point));
    if (distance > 2.0 * params.kernel_m) continue;
    const Point2 before =
        turned_point * std::max(0.0, 1.0 - kBefore / std::max(turned_point.norm(), kBefore));
    Point2 normal = smooth_gradient(field, placed.shifted(before));
    if (normal.squaredNorm() > 1.0) normal.normalize();
    const double root = kernel2 / (kernel2 + distance * distance);
    const Eigen::Vector3d across = jacobian_of(normal, turned_point);
    const Eigen::Vector3d along =
        params.normal_error_rad * jacobian_of({-normal.y(), normal.x()}, turned_point);
    const double weight = root * root * of_one_point;
    information.claimed.noalias() += weight * (across * across.transpose());
    information.observed.noalias() +=
        weight * (across * across.transpose() - along * along.transpose());
  }
  const double yaw = -field.T_grid_frame().yaw;
  return {turned(positive_part(information.claimed), yaw),
          turned(positive_part(information.observed), yaw)};
}

template <typename Field>
Eigen::Matrix3d observed_information(const Field& field, std::span<const Point2> points_base_link,
                                     const Pose2& T_frame_base_link,
                                     const ScanRefinerParams& params) {
  return point_information(field, points_base_link, T_frame_base_link, params).observed;
}

template Pose2 aligned_pose(const DistanceField&, std::span<const Point2>, const Pose2&,
                            const ScanRefinerParams&, const std::optional<PosePrior>&);
template RefinedPose refine_pose(const DistanceField&, std::span<const Point2>, const Pose2&,
                                 const ScanRefinerParams&, const std::optional<PosePrior>&);
template PointInformation point_information(const DistanceField&, std::span<const Point2>,
                                            const Pose2&, const ScanRefinerParams&);
template Eigen::Matrix3d observed_information(const DistanceField&, std::span<const Point2>,
                                              const Pose2&, const ScanRefinerParams&);
template Pose2 aligned_pose(const TiledField&, std::span<const Point2>, const Pose2&,
                            const ScanRefinerParams&, const std::optional<PosePrior>&);
template RefinedPose refine_pose(const TiledField&, std::span<const Point2>, const Pose2&,
                                 const ScanRefinerParams&, const std::optional<PosePrior>&);
template Eigen::Matrix3d observed_information(const TiledField&, std::span<const Point2>,
                                              const Pose2&, const ScanRefinerParams&);

}  // namespace cornerfix

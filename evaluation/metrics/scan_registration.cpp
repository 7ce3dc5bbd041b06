#include "evaluation/metrics/scan_registration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace cornerfix::evaluation {

namespace {

constexpr double kFarthest = 20.0;    // returns beyond hardly constrain a position [m]
constexpr std::ptrdiff_t kReach = 3;  // returns to either side that give a wall's direction
constexpr double kFlat = 0.05;        // of the spread along a wall, the most across it
constexpr int kMaxIterations = 30;
constexpr double kFirstGate = 0.5;  // from a point to the wall that it may lie on [m]
constexpr double kLastGate = 0.06;  // [m]
constexpr double kShrink = 0.8;     // of the gate, an iteration
constexpr double kStray = 0.03;     // scale of the Cauchy loss [m]
constexpr std::size_t kMinPoints = 30;
constexpr std::size_t kMaxReturns = 360;
constexpr double kLeastConstrained =
    0.02;                            // share of the points that constrain the poorest direction
constexpr double kConverged = 1e-5;  // [m], [rad]
constexpr double kSettled = 1e-3;    // [m], [rad]

/// Returns, with the directions of the walls that they lie on.
struct WallPoints {
  Eigen::ArrayXd x;
  Eigen::ArrayXd y;
  std::vector<std::optional<Point2>> normals;
};

std::vector<Point2> near_returns(const LaserScan& scan) {
  std::vector<Point2> points = returns_as_points(scan);
  std::erase_if(points, [](const Point2& point) { return point.norm() > kFarthest; });
  if (points.size() <= kMaxReturns) return points;
  std::vector<Point2> thinned;
  for (std::size_t i = 0; i < kMaxReturns; ++i)
    thinned.push_back(points[i * points.size() / kMaxReturns]);
  return thinned;
}

/// Across the wall through a return and its neighbours, or nothing where they make no line.
std::optional<Point2> normal_at(const std::vector<Point2>& points, std::ptrdiff_t index) {
  const auto last = static_cast<std::ptrdiff_t>(points.size()) - 1;
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, index - kReach);
  const std::ptrdiff_t end = std::min(last, index + kReach) + 1;
  Point2 mean = Point2::Zero();
  for (std::ptrdiff_t i = begin; i < end; ++i) mean += points[static_cast<std::size_t>(i)];
  mean /= static_cast<double>(end - begin);
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const Point2 offset = points[static_cast<std::size_t>(i)] - mean;
    spread += offset * offset.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
  if (axes.eigenvalues()[0] > kFlat * axes.eigenvalues()[1]) return std::nullopt;
  return axes.eigenvectors().col(0);
}

WallPoints wall_points(const LaserScan& scan) {
  const std::vector<Point2> points = near_returns(scan);
  const auto count = static_cast<Eigen::Index>(points.size());
  WallPoints walls{Eigen::ArrayXd(count), Eigen::ArrayXd(count), {}};
  for (Eigen::Index i = 0; i < count; ++i) {
    walls.x[i] = points[static_cast<std::size_t>(i)].x();
    walls.y[i] = points[static_cast<std::size_t>(i)].y();
    walls.normals.push_back(normal_at(points, i));
  }
  return walls;
}

/// The Gauss-Newton system of all points on walls, about one pose.
struct System {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d unweighted = Eigen::Matrix3d::Zero();
  double squared_arms = 0.0;
  std::size_t points = 0;

  void add(const Point2& normal, const Point2& arm, double error) {
    const Eigen::Vector3d jacobian(normal.x(), normal.y(),
                                   normal.y() * arm.x() - normal.x() * arm.y());
    const double weight = 1.0 / (1.0 + (error / kStray) * (error / kStray));
    information += weight * jacobian * jacobian.transpose();
    gradient += weight * error * jacobian;
    unweighted += jacobian * jacobian.transpose();
    squared_arms += arm.squaredNorm();
    ++points;
  }

  /// Radians count by what they move the points.
  [[nodiscard]] bool constrains_a_pose() const {
    if (points < kMinPoints) return false;
    const double arm = std::sqrt(squared_arms / static_cast<double>(points));
    const Eigen::Vector3d scale(1.0, 1.0, 1.0 / arm);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
        scale.asDiagonal() * unweighted * scale.asDiagonal(), Eigen::EigenvaluesOnly);
    return axes.eigenvalues()[0] >= kLeastConstrained * static_cast<double>(points);
  }
};

System linearize(const WallPoints& walls, const std::vector<Point2>& points, const Pose2& T_a_b,
                 double gate_m) {
  System system;
  for (const Point2& point : points) {
    const Point2 seen = T_a_b * point;
    Eigen::Index nearest = 0;
    const double squared =
        ((walls.x - seen.x()).square() + (walls.y - seen.y()).square()).minCoeff(&nearest);
    const std::optional<Point2>& normal = walls.normals[static_cast<std::size_t>(nearest)];
    if (squared > gate_m * gate_m || !normal) continue;
    const Point2 wall(walls.x[nearest], walls.y[nearest]);
    system.add(*normal, seen - T_a_b.translation(), normal->dot(seen - wall));
  }
  return system;
}

}  // namespace

std::optional<Registration> register_scans(const LaserScan& a, const LaserScan& b,
                                           const Pose2& guess) {
  const WallPoints walls = wall_points(a);
  const std::vector<Point2> points = near_returns(b);
  if (walls.normals.empty()) return std::nullopt;
  Registration found{guess, 0.0};
  double gate_m = kFirstGate;
  double last_step = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMaxIterations; ++i) {
    const System system = linearize(walls, points, found.T_a_b, gate_m);
    if (!system.constrains_a_pose()) return std::nullopt;
    found.inlier_share = static_cast<double>(system.points) / static_cast<double>(points.size());
    const Eigen::Vector3d step = -system.information.ldlt().solve(system.gradient);
    found.T_a_b = {found.T_a_b.x + step.x(), found.T_a_b.y + step.y(),
                   wrap_angle(found.T_a_b.yaw + step.z())};
    last_step = step.cwiseAbs().maxCoeff();
    if (gate_m <= kLastGate && last_step < kConverged) break;
    gate_m = std::max(kLastGate, kShrink * gate_m);
  }
  if (last_step > kSettled) return std::nullopt;
  return found;
}

}  // namespace cornerfix::evaluation

#include "evaluation/datasets/bag/point_cloud_slice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace cornerfix::evaluation {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kFinestStep = 0.25 / 360.0 * kTurn;
constexpr double kCoarsestStep = 2.0 / 360.0 * kTurn;
constexpr double kSameBearing = kFinestStep / 10.0;

constexpr double kNoReturn = 1e-6;  // [m]

struct PolarPoint {
  double bearing;
  double range;
};

/// By bearing.
std::vector<PolarPoint> points_in_band(const PointCloudMessage& cloud,
                                       const Eigen::Matrix3d& rotation, const HeightBand& band) {
  const double heading = std::atan2(rotation(1, 0), rotation(0, 0));
  const Eigen::Matrix3d R_level_cloud =
      Eigen::AngleAxisd(-heading, Eigen::Vector3d::UnitZ()) * rotation;
  std::vector<PolarPoint> points;
  for (const Eigen::Vector3f& point : cloud.points) {
    const Eigen::Vector3d level = R_level_cloud * point.cast<double>();
    if (level.z() < band.min_m || level.z() > band.max_m) continue;
    // Many drivers put a point without return at the origin.
    if (level.isZero(kNoReturn)) continue;
    points.push_back({std::atan2(level.y(), level.x()), level.head<2>().norm()});
  }
  std::ranges::sort(points, {}, &PolarPoint::bearing);
  return points;
}

/// The median distance of neighbouring bearings, such that a whole number of them is a turn.
double step_between(const std::vector<PolarPoint>& points) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double step = points[i].bearing - points[i - 1].bearing;
    if (step > kSameBearing) steps.push_back(step);
  }
  if (steps.empty()) return kCoarsestStep;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  return kTurn / std::round(kTurn / std::clamp(*middle, kFinestStep, kCoarsestStep));
}

}  // namespace

LaserScan slice(const PointCloudMessage& cloud, const Eigen::Matrix3d& rotation,
                const HeightBand& band) {
  const std::vector<PolarPoint> points = points_in_band(cloud, rotation, band);
  LaserScan scan;
  scan.stamp = cloud.stamp;
  scan.angle_increment = step_between(points);
  scan.angle_min = points.empty() ? -std::numbers::pi : points.front().bearing;
  scan.range_max = std::numeric_limits<double>::infinity();
  const auto beams = static_cast<std::size_t>(std::lround(kTurn / scan.angle_increment));
  scan.ranges.assign(beams, std::numeric_limits<float>::quiet_NaN());
  for (const auto& [bearing, range] : points) {
    const double steps = (bearing - scan.angle_min) / scan.angle_increment;
    float& nearest = scan.ranges[static_cast<std::size_t>(std::lround(steps)) % beams];
    const auto here = static_cast<float>(range);
    if (!(nearest <= here)) nearest = here;
  }
  return scan;
}

}  // namespace cornerfix::evaluation

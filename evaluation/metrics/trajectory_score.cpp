#include "evaluation/metrics/trajectory_score.hpp"

#include <algorithm>
#include <cmath>

namespace cornerfix::evaluation {

std::vector<std::size_t> reference_scans(std::span<const LogScan> scans) {
  const bool marks_key_scans =
      std::ranges::any_of(scans, [](const LogScan& scan) { return scan.is_key_scan; });
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (scans[i].T_map_laser && (!marks_key_scans || scans[i].is_key_scan)) indices.push_back(i);
  }
  return indices;
}

RelativePoseError relative_pose_error(std::span<const LogScan> scans,
                                      std::span<const Pose2> T_any_laser, double path_length_m) {
  const std::vector<std::size_t> indices = reference_scans(scans);
  const auto reference = [&](std::size_t n) { return *scans[indices[n]].T_map_laser; };
  std::vector<double> path_lengths_m(indices.size(), 0.0);
  for (std::size_t n = 1; n < indices.size(); ++n)
    path_lengths_m[n] = path_lengths_m[n - 1] + distance(reference(n - 1), reference(n));

  RelativePoseError error{.path_length_m = path_length_m, .errors_m = {}, .errors_rad = {}};
  for (std::size_t from = 0; from < indices.size(); ++from) {
    const auto reached =
        std::ranges::lower_bound(path_lengths_m, path_lengths_m[from] + path_length_m);
    if (reached == path_lengths_m.end()) break;
    const auto to = static_cast<std::size_t>(reached - path_lengths_m.begin());
    const Pose2 expected = inverse(reference(from)) * reference(to);
    const Pose2 found = inverse(T_any_laser[indices[from]]) * T_any_laser[indices[to]];
    const Pose2 difference = inverse(expected) * found;
    error.errors_m.push_back(std::hypot(difference.x, difference.y));
    error.errors_rad.push_back(std::abs(difference.yaw));
  }
  return error;
}

Pose2 align_to_reference(std::span<const LogScan> scans, std::span<const Pose2> T_any_laser) {
  const std::vector<std::size_t> indices = reference_scans(scans);
  if (indices.empty()) return {};
  Point2 mean_any = Point2::Zero();
  Point2 mean_map = Point2::Zero();
  for (const std::size_t i : indices) {
    mean_any += T_any_laser[i].translation() / static_cast<double>(indices.size());
    mean_map += scans[i].T_map_laser->translation() / static_cast<double>(indices.size());
  }
  double cosine = 0.0;
  double sine = 0.0;
  for (const std::size_t i : indices) {
    const Point2 a = T_any_laser[i].translation() - mean_any;
    const Point2 b = scans[i].T_map_laser->translation() - mean_map;
    cosine += a.dot(b);
    sine += a.x() * b.y() - a.y() * b.x();
  }
  const Pose2 turn{0.0, 0.0, std::atan2(sine, cosine)};
  const Point2 offset = mean_map - turn * mean_any;
  return {offset.x(), offset.y(), turn.yaw};
}

}  // namespace cornerfix::evaluation

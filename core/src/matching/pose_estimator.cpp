#include "core/src/matching/pose_estimator.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>

#include "core/src/base/bounded_draw.hpp"

namespace cornerfix {
namespace {

constexpr int kMaxRefits = 10;

/// How many correspondences a pose explains, and how well.
struct Support {
  int inliers = 0;
  double squared_residuals = 0.0;

  [[nodiscard]] bool is_better_than(const Support& other) const {
    return inliers > other.inliers ||
           (inliers == other.inliers && squared_residuals < other.squared_residuals);
  }
};

class Consensus {
 public:
  Consensus(std::span<const Correspondence> correspondences, double inlier_distance_m)
      : correspondences_(correspondences),
        order_(correspondences.size()),
        squared_inlier_distance_(inlier_distance_m * inlier_distance_m) {
    // What is offered for one submap point stands together, so that it can count once.
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::ranges::stable_sort(order_, {}, [&](std::size_t i) {
      return std::pair(correspondences[i].point_submap.x(), correspondences[i].point_submap.y());
    });
  }

  [[nodiscard]] Support support(const Pose2& T_map_submap) const {
    Support support;
    for_each_inlier(T_map_submap, [&](std::size_t, double squared_residual) {
      ++support.inliers;
      support.squared_residuals += squared_residual;
    });
    return support;
  }

  /// Ascending.
  [[nodiscard]] std::vector<std::size_t> inliers(const Pose2& T_map_submap) const {
    std::vector<std::size_t> indices;
    for_each_inlier(T_map_submap, [&](std::size_t i, double) { indices.push_back(i); });
    std::ranges::sort(indices);
    return indices;
  }

 private:
  /// Visits the nearest offer of each submap point, where that is an inlier.
  template <typename Visit>
  void for_each_inlier(const Pose2& T_map_submap, Visit visit) const {
    const double c = std::cos(T_map_submap.yaw);
    const double s = std::sin(T_map_submap.yaw);
    for (std::size_t next = 0; next < order_.size();) {
      const Point2 p = correspondences_[order_[next]].point_submap;
      const Point2 expected(T_map_submap.x + c * p.x() - s * p.y(),
                            T_map_submap.y + s * p.x() + c * p.y());
      std::size_t nearest = order_[next];
      double least = (correspondences_[nearest].point_map - expected).squaredNorm();
      for (++next; next < order_.size() && correspondences_[order_[next]].point_submap == p;
           ++next) {
        const double squared = (correspondences_[order_[next]].point_map - expected).squaredNorm();
        if (squared >= least) continue;
        least = squared;
        nearest = order_[next];
      }
      if (least <= squared_inlier_distance_) visit(nearest, least);
    }
  }

  std::span<const Correspondence> correspondences_;
  std::vector<std::size_t> order_;
  double squared_inlier_distance_;
};

/// Whether one rigid motion can make inliers of both, and both fix a direction.
bool are_consistent(const Correspondence& a, const Correspondence& b, double inlier_distance_m) {
  const double in_submap = (a.point_submap - b.point_submap).norm();
  const double in_map = (a.point_map - b.point_map).norm();
  const double tolerance = 2.0 * inlier_distance_m;
  return std::min(in_submap, in_map) > tolerance && std::abs(in_submap - in_map) <= tolerance;
}

std::vector<Correspondence> select(std::span<const Correspondence> correspondences,
                                   const std::vector<std::size_t>& indices) {
  std::vector<Correspondence> selected;
  selected.reserve(indices.size());
  for (const std::size_t i : indices) selected.push_back(correspondences[i]);
  return selected;
}

/// The pose of the best supported pair.
std::optional<Pose2> sample_best(std::span<const Correspondence> correspondences,
                                 const Consensus& consensus, const PoseEstimatorParams& params) {
  std::mt19937_64 random(params.seed);
  std::optional<Pose2> best;
  Support best_support;
  for (int iteration = 0; iteration < params.max_iterations; ++iteration) {
    const std::array pair{correspondences[bounded_draw(random, correspondences.size())],
                          correspondences[bounded_draw(random, correspondences.size())]};
    if (!are_consistent(pair[0], pair[1], params.inlier_distance_m)) continue;
    const std::optional<Pose2> T_map_submap = fit_rigid(pair);
    if (!T_map_submap) continue;
    const Support support = consensus.support(*T_map_submap);
    if (!support.is_better_than(best_support)) continue;
    best = T_map_submap;
    best_support = support;
  }
  return best;
}

/// Fits all inliers, then those of the fit, as long as that explains more.
Pose2 refit(std::span<const Correspondence> correspondences, const Consensus& consensus,
            Pose2 T_map_submap) {
  Support support = consensus.support(T_map_submap);
  for (int round = 0; round < kMaxRefits; ++round) {
    const auto fitted = fit_rigid(select(correspondences, consensus.inliers(T_map_submap)));
    if (!fitted) break;
    const Support fitted_support = consensus.support(*fitted);
    if (!fitted_support.is_better_than(support)) break;
    T_map_submap = *fitted;
    support = fitted_support;
  }
  return T_map_submap;
}

}  // namespace

std::optional<Error> validate(const PoseEstimatorParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!(params.inlier_distance_m > 0.0) || !std::isfinite(params.inlier_distance_m)) {
    return broken("inlier_distance_m", "must be a finite length in metres above 0");
  }
  if (params.min_inliers < 2) return broken("min_inliers", "must be at least 2");
  if (params.max_iterations < 1 || params.max_iterations > 10'000)
    return broken("max_iterations", "must be in [1, 10000]");
  return std::nullopt;
}

std::optional<Pose2> fit_rigid(std::span<const Correspondence> correspondences) {
  Point2 mean_submap = Point2::Zero();
  Point2 mean_map = Point2::Zero();
  for (const Correspondence& c : correspondences) {
    mean_submap += c.point_submap;
    mean_map += c.point_map;
  }
  const auto count = static_cast<double>(std::max<std::size_t>(correspondences.size(), 1));
  mean_submap /= count;
  mean_map /= count;
  double dot = 0.0;
  double cross = 0.0;
  double spread = 0.0;
  for (const Correspondence& c : correspondences) {
    const Point2 p = c.point_submap - mean_submap;
    const Point2 q = c.point_map - mean_map;
    dot += p.dot(q);
    cross += p.x() * q.y() - p.y() * q.x();
    spread += p.norm() * q.norm();
  }
  constexpr double kRoundingErrors = 1e-9;
  if (std::hypot(dot, cross) <= kRoundingErrors * std::max(spread, kRoundingErrors)) {
    return std::nullopt;
  }
  const double yaw = std::atan2(cross, dot);
  const Point2 translation = mean_map - Pose2{0.0, 0.0, yaw} * mean_submap;
  return Pose2{translation.x(), translation.y(), wrap_angle(yaw)};
}

std::optional<PoseEstimate> estimate_pose(std::span<const Correspondence> correspondences,
                                          const PoseEstimatorParams& params) {
  assert(!validate(params) && "params must pass validate()");
  if (correspondences.empty()) return std::nullopt;
  const Consensus consensus(correspondences, params.inlier_distance_m);
  const std::optional<Pose2> sampled = sample_best(correspondences, consensus, params);
  if (!sampled) return std::nullopt;
  const Pose2 T_map_submap = refit(correspondences, consensus, *sampled);
  const Support support = consensus.support(T_map_submap);
  if (support.inliers < params.min_inliers) return std::nullopt;
  const double rms = std::sqrt(support.squared_residuals / support.inliers);
  return PoseEstimate{T_map_submap, consensus.inliers(T_map_submap), rms};
}

}  // namespace cornerfix

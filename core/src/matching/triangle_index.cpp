#include "core/src/matching/triangle_index.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <iterator>
#include <numbers>
#include <random>
#include <utility>

#include "core/src/base/bounded_draw.hpp"
#include "core/src/matching/point_grid.hpp"
#include "core/src/matching/pose_estimator.hpp"
#include "core/src/matching/triangle_table.hpp"

namespace cornerfix {
namespace {

constexpr std::size_t kMinInliers = 4;  // one more than give the transform
constexpr int kMaxTransformRefits = 20;
constexpr std::size_t kMaxTests = 32;    // by then the test has long decided
constexpr double kHopelessRatio = -3.0;  // log-likelihood ratio at which a transform is given up
// Matches nearer than this are one place.
constexpr double kSameTransform = 1.0;  // [m]
constexpr double kSameHeading = 0.2;    // [rad]

std::vector<Point2> positions(std::span<const Feature> features) {
  std::vector<Point2> points;
  points.reserve(features.size());
  std::ranges::transform(features, std::back_inserter(points), &Feature::position);
  return points;
}

/// Median distance of a point to the k-th nearest other, over a sample of the points: what "near"
/// means in this map of any outline. 0 for fewer than two points.
double reach_of(std::span<const Point2> points, std::size_t k) {
  constexpr std::size_t kSample = 101;
  std::vector<double> reaches;
  std::vector<double> distances(points.size());
  std::vector<double> nearest(std::min(k + 1, points.size()));  // the point itself is the first
  if (nearest.size() < 2) return 0.0;
  for (std::size_t i = 0; i < points.size(); i += points.size() / kSample + 1) {
    std::ranges::transform(points, distances.begin(),
                           [&](const Point2& p) { return (p - points[i]).squaredNorm(); });
    std::partial_sort_copy(distances.begin(), distances.end(), nearest.begin(), nearest.end());
    reaches.push_back(std::sqrt(nearest.back()));
  }
  const auto middle = reaches.begin() + static_cast<std::ptrdiff_t>(reaches.size() / 2);
  std::ranges::nth_element(reaches, middle);
  return *middle;
}

/// ln n!. Not by std::lgamma(), which writes a global that threads would race for.
double log_factorial(int n) {
  int sign = 0;
  return ::lgamma_r(n + 1.0, &sign);
}

/// ln P(at least k of n), each with probability p.
double log_binomial_tail(int n, int k, double p) {
  const double log_first = log_factorial(n) - log_factorial(k) - log_factorial(n - k) +
                           k * std::log(p) + (n - k) * std::log1p(-p);
  double sum = 0.0;
  double term = 1.0;  // relative to the first
  for (int i = k; i <= n && term > 1e-12 * sum; ++i) {
    sum += term;
    term *= (n - i) / (i + 1.0) * p / (1.0 - p);
  }
  return log_first + std::log(sum);
}

}  // namespace

struct TriangleIndex::Data {
  TriangleLimits limits;
  double chance;  ///< Probability that a point lies on a feature by chance.
  PointGrid grid;
  TriangleTable table;
};

/// One search for a submap in a map.
class TriangleIndex::Search {
 public:
  Search(const Data& map, std::span<const Feature> features_submap,
         const TriangleMatchParams& params)
      : map_(map),
        params_(params),
        log_hit_(std::log(params.overlap / map.chance)),
        log_miss_(std::log((1.0 - params.overlap) / (1.0 - map.chance))),
        submap_(positions(features_submap)),
        corners_(submap_.size()) {
    std::mt19937_64 random(params.seed);
    for (std::size_t i = submap_.size(); i > 1; --i)
      std::swap(submap_[i - 1], submap_[bounded_draw(random, i)]);
  }

  /// Each point in turn gives one more triangle: those of a point that the map does not hold are
  /// all in vain.
  std::vector<TriangleMatch> run() {
    for (bool more = true; more && !is_over();) {
      more = false;
      for (std::uint32_t corner = 0; corner < corners_.size() && !is_over(); ++corner)
        more |= try_next_triangle(corner);
    }
    std::ranges::sort(matches_, {}, &TriangleMatch::log_false_alarms);
    return std::move(matches_);
  }

 private:
  /// A point of the submap, with the triangles that it has still to give.
  struct Corner {
    std::vector<std::uint32_t> near;  ///< Points within the longest side, in random order.
    std::size_t second = 1;           ///< Into `near`; the next triangle has these two.
    std::size_t third = 0;
  };

  [[nodiscard]] bool is_over() const {
    return trials_ >= params_.max_trials || matches_.size() >= params_.max_matches;
  }

  /// False when the corner has no triangle left.
  bool try_next_triangle(std::uint32_t first) {
    Corner& corner = corners_[first];
    if (corner.near.empty()) corner.near = points_near(first);
    while (corner.second < corner.near.size() && !is_over()) {
      const std::uint32_t second = corner.near[corner.second];
      const std::uint32_t third = corner.near[corner.third];
      if (++corner.third >= corner.second) {
        ++corner.second;
        corner.third = 0;
      }
      ++trials_;
      if (second < first || third < first) continue;  // That corner gives it.
      const auto triangle =
          triangle_of(submap_[first], submap_[second], submap_[third], map_.limits);
      if (!triangle) continue;
      try_congruent(*triangle, {first, second, third});
      return true;
    }
    return false;
  }

  [[nodiscard]] std::vector<std::uint32_t> points_near(std::uint32_t corner) const {
    std::vector<std::uint32_t> near;
    for (std::uint32_t i = 0; i < submap_.size(); ++i) {
      if (i != corner && (submap_[i] - submap_[corner]).norm() <= map_.limits.max_side_m)
        near.push_back(i);
    }
    return near;
  }

  /// Points near a triangle, where its error moves them the least, in its frame.
  [[nodiscard]] std::vector<Point2> tests_for(const std::array<std::uint32_t, 3>& vertices,
                                              const Pose2& T_triangle_submap) const {
    std::vector<Point2> tests;
    tests.reserve(kMaxTests);
    for (const std::uint32_t i : corners_[vertices[0]].near) {
      if (tests.size() == kMaxTests) break;
      if (i != vertices[1] && i != vertices[2]) tests.push_back(T_triangle_submap * submap_[i]);
    }
    return tests;
  }

  /// The first of the vertices is the corner whose turn it is.
  void try_congruent(const Triangle& triangle, const std::array<std::uint32_t, 3>& vertices) {
    frames_.clear();
    map_.table.find_congruent(triangle, frames_);
    if (frames_.empty()) return;
    const Pose2 T_triangle_submap = inverse(triangle.frame);
    const std::vector<Point2> tests_triangle = tests_for(vertices, T_triangle_submap);
    for (const Pose2& T_map_triangle : frames_) {
      if (is_over()) return;
      ++trials_;
      if (is_promising(T_map_triangle, tests_triangle)) verify(T_map_triangle * T_triangle_submap);
    }
  }

  /// The sequential test: every point on a feature supports the transform, every other contradicts
  /// it.
  [[nodiscard]] bool is_promising(const Pose2& T_map_triangle,
                                  std::span<const Point2> tests_triangle) const {
    const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(T_map_triangle.yaw).toRotationMatrix();
    const Point2 translation = T_map_triangle.translation();
    double log_ratio = 0.0;
    int hits = 0;
    for (const Point2& point : tests_triangle) {
      const bool hit = map_.grid.nearest(translation + rotation * point).has_value();
      log_ratio += hit ? log_hit_ : log_miss_;
      hits += hit ? 1 : 0;
      if (log_ratio < kHopelessRatio) return false;
    }
    return hits > 0;
  }

  /// Fits all inliers, then those of the fit, until that changes nothing.
  void verify(Pose2 T_map_submap) {
    std::vector<Correspondence> inliers;
    for (int round = 0; round < kMaxTransformRefits; ++round) {
      inliers = inliers_of(T_map_submap);
      const std::optional<Pose2> fitted = fit_rigid(inliers);
      if (inliers.size() < kMinInliers || !fitted) return;
      const bool settled = *fitted == T_map_submap;
      T_map_submap = *fitted;
      if (settled) break;
    }
    const int count = static_cast<int>(inliers.size());
    const double log_false_alarms = log_false_alarms_of(count);
    if (log_false_alarms > params_.max_log_false_alarms) return;
    keep({T_map_submap, count, log_false_alarms, trials_});
  }

  [[nodiscard]] std::vector<Correspondence> inliers_of(const Pose2& T_map_submap) const {
    std::vector<Correspondence> inliers;
    for (const Point2& point : submap_) {
      if (const auto feature = map_.grid.nearest(T_map_submap * point))
        inliers.push_back({point, *feature});
    }
    return inliers;
  }

  /// Of as many transforms as there are pairs of points in the submap and in the map: two points
  /// give a transform, the others lie on features by chance.
  [[nodiscard]] double log_false_alarms_of(int inliers) const {
    const auto in_submap = static_cast<double>(submap_.size());
    const auto in_map = static_cast<double>(map_.grid.points().size());
    return 2.0 * std::log(in_submap * in_map) +
           log_binomial_tail(static_cast<int>(submap_.size()) - 2, inliers - 2, map_.chance);
  }

  void keep(const TriangleMatch& match) {
    for (TriangleMatch& known : matches_) {
      if (!is_same_place(known.T_map_submap, match.T_map_submap)) continue;
      if (match.log_false_alarms < known.log_false_alarms) known = match;
      return;
    }
    matches_.push_back(match);
  }

  /// Compared where the submap lies, which may be far from its origin.
  [[nodiscard]] bool is_same_place(const Pose2& a, const Pose2& b) const {
    return (a * submap_.front() - b * submap_.front()).norm() < kSameTransform &&
           angle_between(a, b) < kSameHeading;
  }

  const Data& map_;
  const TriangleMatchParams& params_;
  double log_hit_;
  double log_miss_;
  std::vector<Point2> submap_;  ///< In random order.
  std::vector<Corner> corners_;
  std::vector<Pose2> frames_;  ///< Kept for its memory.
  std::size_t trials_ = 0;
  std::vector<TriangleMatch> matches_;
};

std::optional<Error> validate(const TriangleIndexParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!(params.min_side_m > 0.0)) return broken("min_side_m", "must be above 0 m");
  if (params.neighbors < 3 || params.neighbors > 100)
    return broken("neighbors", "must be in [3, 100]");
  if (!(params.tolerance_m > 0.0)) return broken("tolerance_m", "must be above 0 m");
  return std::nullopt;
}

std::optional<Error> validate(const TriangleMatchParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!(params.overlap > 0.0 && params.overlap < 1.0))
    return broken("overlap", "must be in (0, 1)");
  if (!(params.max_log_false_alarms < 0.0))
    return broken("max_log_false_alarms", "must be below 0");
  if (params.max_trials < 1) return broken("max_trials", "must be at least 1");
  if (params.max_matches < 1) return broken("max_matches", "must be at least 1");
  return std::nullopt;
}

TriangleIndex::TriangleIndex() : TriangleIndex({}, {}) {}

TriangleIndex::TriangleIndex(std::span<const Feature> features_map,
                             const TriangleIndexParams& params) {
  assert(!validate(params) && "params must pass validate()");
  PointGrid grid(positions(features_map), params.tolerance_m);
  const auto neighbors = static_cast<std::size_t>(params.neighbors);
  const double reach = std::max(reach_of(grid.points(), neighbors), 3.0 * params.min_side_m);
  const double share = params.tolerance_m / reach;
  const double chance = std::clamp(params.neighbors * share * share, 1e-6, 0.2);
  const TriangleLimits limits{params.min_side_m, reach, params.tolerance_m};
  TriangleTable table(grid, limits, 2 * neighbors);
  data_ = std::make_shared<const Data>(Data{limits, chance, std::move(grid), std::move(table)});
}

std::vector<TriangleMatch> TriangleIndex::match(std::span<const Feature> features_submap,
                                                const TriangleMatchParams& params) const {
  assert(!validate(params) && "params must pass validate()");
  return Search(*data_, features_submap, params).run();
}

std::size_t TriangleIndex::triangle_count() const { return data_->table.size(); }

std::size_t TriangleIndex::memory_bytes() const {
  return data_->grid.memory_bytes() + data_->table.memory_bytes();
}

}  // namespace cornerfix

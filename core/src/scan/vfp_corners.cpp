#include "core/src/scan/vfp_corners.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

namespace cornerfix {
namespace {

/// A corner before suppression, with the beam it was seen by.
struct VfpCandidate {
  Feature feature;
  std::uint32_t beam = 0;
};

/// The vector filter of eqs. (2)-(6) on one segment.
class VectorFilter {
 public:
  VectorFilter(std::span<const ScanPoint> segment, const VfpParams& params)
      : segment_(segment),
        squared_neighbor_distance_(params.neighbor_distance_m * params.neighbor_distance_m),
        squared_inlier_distance_(params.inlier_distance_m * params.inlier_distance_m),
        max_straightness_(std::cos(params.min_turn_angle_rad)) {}

  /// p_k as a corner, or nothing when it is the end of a segment, a bump or flat.
  [[nodiscard]] std::optional<Feature> corner_at(std::size_t k) const {
    const std::optional<std::size_t> l = neighbor(k, -1);
    if (!l) return std::nullopt;
    const std::optional<std::size_t> r = neighbor(k, 1);
    if (!r) return std::nullopt;
    const Point2 L = (point(*l) - point(k)).normalized();  // Eq. (2)
    const Point2 R = (point(*r) - point(k)).normalized();  // Eq. (3)
    const double straightness = -L.dot(R);
    // The angle first: it settles most points of a noisy wall without a look at their arms.
    if (straightness >= max_straightness_) return std::nullopt;
    if (!is_straight(*l + 1, k, k, L) || !is_straight(k + 1, *r, k, R)) return std::nullopt;
    Feature feature;
    feature.position = point(k);
    feature.turn_angle = std::acos(std::clamp(straightness, -1.0, 1.0));  // Eq. (6)
    feature.weight = feature.turn_angle;
    const Point2 bisector = L + R;
    feature.bisector = std::atan2(bisector.y(), bisector.x());
    feature.convex = bisector.dot(feature.position) > 0.0;
    return feature;
  }

 private:
  [[nodiscard]] const Point2& point(std::size_t i) const { return segment_[i].position; }

  /// The first point farther than t_neigh from p_k, walking by `step`.
  [[nodiscard]] std::optional<std::size_t> neighbor(std::size_t k, std::ptrdiff_t step) const {
    const Point2 p_k = point(k);
    const auto size = static_cast<std::ptrdiff_t>(segment_.size());
    for (auto i = static_cast<std::ptrdiff_t>(k) + step; i >= 0 && i < size; i += step) {
      const auto index = static_cast<std::size_t>(i);
      if ((point(index) - p_k).squaredNorm() > squared_neighbor_distance_) return index;
    }
    return std::nullopt;
  }

  /// Whether the points [begin, end) lie within t_in of the ray from p_k along `direction`. These
  /// are the distances of eqs. (4) and (5), counted from p_k itself for a point behind it.
  [[nodiscard]] bool is_straight(std::size_t begin, std::size_t end, std::size_t k,
                                 const Point2& direction) const {
    const Point2 p_k = point(k);
    for (std::size_t i = begin; i < end; ++i) {
      const Point2 v = point(i) - p_k;
      const double along = std::max(direction.dot(v), 0.0);
      if (v.squaredNorm() - along * along > squared_inlier_distance_) return false;
    }
    return true;
  }

  std::span<const ScanPoint> segment_;
  double squared_neighbor_distance_;
  double squared_inlier_distance_;
  double max_straightness_;
};

/// Coarse selection by eq. (1), then the vector filter, for the points [begin, end).
void append_corners(std::span<const ScanPoint> segment, std::size_t begin, std::size_t end,
                    const VfpParams& params, std::vector<VfpCandidate>& candidates) {
  const std::vector<double> scores = smoothness_scores(segment, params.window);
  const VectorFilter filter(segment, params);
  for (std::size_t k = begin; k < end; ++k) {
    if (scores[k] <= params.min_score) continue;
    if (const auto corner = filter.corner_at(k)) {
      candidates.push_back({*corner, segment[k].beam});
    }
  }
}

/// A closed segment with half a turn more on either side, so that every point of the middle turn
/// has its neighbours beside it.
std::vector<ScanPoint> unrolled(const std::vector<ScanPoint>& points) {
  const auto half = static_cast<std::ptrdiff_t>(points.size() / 2);
  std::vector<ScanPoint> result(points.end() - half, points.end());
  result.insert(result.end(), points.begin(), points.end());
  result.insert(result.end(), points.begin(), points.begin() + half);
  return result;
}

/// Keeps the largest a in each neighbourhood; of equal ones the first beam.
std::vector<VfpCandidate> suppress_weaker(std::vector<VfpCandidate> candidates, double radius_m) {
  std::ranges::stable_sort(candidates, [](const VfpCandidate& a, const VfpCandidate& b) {
    return a.feature.weight > b.feature.weight;
  });
  std::vector<VfpCandidate> kept;
  for (const VfpCandidate& candidate : candidates) {
    const bool weaker = std::ranges::any_of(kept, [&](const VfpCandidate& other) {
      return (other.feature.position - candidate.feature.position).squaredNorm() <
             radius_m * radius_m;
    });
    if (!weaker) kept.push_back(candidate);
  }
  return kept;
}

}  // namespace

VfpParams vfp_params_for(double angle_increment_rad) {
  constexpr double kFine = 0.25 * std::numbers::pi / 180.0;
  constexpr double kCoarse = 1.0 * std::numbers::pi / 180.0;
  const double share = std::clamp(
      std::log(std::abs(angle_increment_rad) / kFine) / std::log(kCoarse / kFine), 0.0, 1.0);
  VfpParams params;
  params.window = static_cast<int>(std::lround(std::lerp(10.0, 4.0, share)));
  params.min_score = 0.001 * std::pow(4.0, share);
  params.inlier_distance_m = std::lerp(0.15, 0.12, share);
  params.min_turn_angle_rad = std::lerp(35.0, 30.0, share) * std::numbers::pi / 180.0;
  return params;
}

std::optional<Error> validate(const VfpParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  const auto is_length = [](double value) { return value > 0.0 && std::isfinite(value); };
  constexpr const char* kLength = "must be a finite length in metres above 0";
  if (auto error = validate(params.segments)) {
    error->field = "segments." + error->field;
    return error;
  }
  if (params.window < 1) return broken("window", "must be at least 1");
  if (!(params.min_score >= 0.0)) return broken("min_score", "must not be negative");
  if (!is_length(params.neighbor_distance_m)) return broken("neighbor_distance_m", kLength);
  if (!is_length(params.inlier_distance_m)) return broken("inlier_distance_m", kLength);
  if (!(params.min_turn_angle_rad > 0.0 && params.min_turn_angle_rad < std::numbers::pi)) {
    return broken("min_turn_angle_rad", "must be an angle in (0, pi)");
  }
  if (!is_length(params.suppression_radius_m)) return broken("suppression_radius_m", kLength);
  return std::nullopt;
}

std::vector<double> smoothness_scores(std::span<const ScanPoint> segment, int window) {
  const std::size_t size = segment.size();
  const auto reach = static_cast<std::size_t>(window);
  std::vector<double> scores(size, 0.0);
  Point2 sum = Point2::Zero();  // Of the points [first, last).
  std::size_t first = 0;
  std::size_t last = 0;
  for (std::size_t k = 0; k < size; ++k) {
    while (last < std::min(k + reach + 1, size)) sum += segment[last++].position;
    while (first + reach < k) sum -= segment[first++].position;
    const auto others = static_cast<double>(last - first - 1);
    if (others == 0.0) continue;
    // Eq. (1); h_k itself adds a zero to the sum.
    const Point2 difference = (others + 1.0) * segment[k].position - sum;
    scores[k] = difference.norm() / (others * segment[k].range);
  }
  return scores;
}

std::vector<Feature> extract_vfp_corners(const LaserScan& scan, const VfpParams& params) {
  assert(!validate(params) && "params must pass validate()");
  std::vector<VfpCandidate> candidates;
  for (const ScanSegment& segment : cut_into_segments(scan, params.segments)) {
    const std::size_t size = segment.points.size();
    if (segment.closed) {
      append_corners(unrolled(segment.points), size / 2, size / 2 + size, params, candidates);
    } else {
      append_corners(segment.points, 0, size, params, candidates);
    }
  }
  std::vector<VfpCandidate> kept =
      suppress_weaker(std::move(candidates), params.suppression_radius_m);
  std::ranges::sort(kept, {}, &VfpCandidate::beam);
  std::vector<Feature> corners;
  corners.reserve(kept.size());
  for (const VfpCandidate& candidate : kept) corners.push_back(candidate.feature);
  return corners;
}

}  // namespace cornerfix

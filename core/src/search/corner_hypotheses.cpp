#include "core/src/search/corner_hypotheses.hpp"

#include <algorithm>
#include <cmath>

#include "core/src/base/thinned.hpp"
#include "core/src/base/within.hpp"
#include "core/src/search/map_index.hpp"
#include "core/src/search/same_place.hpp"

namespace cornerfix {
namespace {

constexpr double kReach = 6.0;  // ends nearer than this to a corner judge it [m]: farther ones
                                // would ask for a better heading than a corner has
constexpr std::size_t kJudges = 32;
constexpr std::size_t kFirstJudges = 8;      // after which a hopeless pose is given up
constexpr double kHopelessMean = -0.3;       // [nat]
constexpr double kMaxTurnDifference = 0.35;  // between two views of one corner [rad]
constexpr std::size_t kMaxTriangleMatches = 2;

/// The hypotheses found so far, each place once.
class Places {
 public:
  Places(const LocalizationMap& map, const CornerHypothesisParams& params)
      : map_(map), params_(params) {}

  /// `judges` are evenly mixed, so that some of them represent all.
  void judge(const Pose2& T_map_base_link, std::span<const Point2> judges) {
    if (judges.empty() || !is_free(T_map_base_link.translation())) return;
    const std::size_t first = std::min(kFirstJudges, judges.size());
    double sum = map_.index().place_search.sum_of_weights(judges.first(first), T_map_base_link);
    if (sum < kHopelessMean * static_cast<double>(first)) return;
    sum += map_.index().place_search.sum_of_weights(judges.subspan(first), T_map_base_link);
    const double mean = sum / static_cast<double>(judges.size());
    if (mean >= params_.min_mean_weight) add({T_map_base_link, mean});
  }

  [[nodiscard]] std::vector<Hypothesis> take() { return std::move(places_); }

 private:
  [[nodiscard]] bool is_free(const Point2& point_map) const {
    const ClassField& classes = map_.index().classes;
    const Point2 cell = (classes.T_grid_map() * point_map) / classes.resolution();
    const auto pass = static_cast<PassClass>(classes.pass_class(
        static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y()))));
    return pass == PassClass::kFree || pass == PassClass::kNearWall;
  }

  void add(const Hypothesis& one) {
    const auto same = std::ranges::find_if(places_, [&](const Hypothesis& other) {
      return is_same_place(one.T_map_base_link, other.T_map_base_link);
    });
    if (same != places_.end()) {
      if (same->mean_weight >= one.mean_weight) return;
      places_.erase(same);
    }
    const auto worse = std::ranges::upper_bound(places_, one.mean_weight, std::ranges::greater{},
                                                &Hypothesis::mean_weight);
    places_.insert(worse, one);
    if (places_.size() > params_.max_places) places_.pop_back();
  }

  const LocalizationMap& map_;
  const CornerHypothesisParams& params_;
  std::vector<Hypothesis> places_;  // Best first.
};

/// Some of the ends about a corner, mixed.
std::vector<Point2> judges_of(const Feature& corner, std::span<const Point2> ends) {
  std::vector<Point2> near;
  std::ranges::copy_if(ends, std::back_inserter(near),
                       [&](const Point2& end) { return (end - corner.position).norm() <= kReach; });
  near = thinned(near, kJudges);
  std::vector<Point2> mixed;
  mixed.reserve(near.size());
  constexpr std::size_t kStep = kJudges / kFirstJudges;
  for (std::size_t first = 0; first < kStep; ++first) {
    for (std::size_t i = first; i < near.size(); i += kStep) mixed.push_back(near[i]);
  }
  return mixed;
}

/// The pose at which a corner seen is a corner of the map.
Pose2 pose_from(const Feature& corner_map, const Feature& corner_base_link) {
  const double yaw = wrap_angle(corner_map.bisector - corner_base_link.bisector);
  const Point2 turned = Pose2{0.0, 0.0, yaw} * corner_base_link.position;
  return {corner_map.position.x() - turned.x(), corner_map.position.y() - turned.y(), yaw};
}

bool may_be_same(const Feature& a, const Feature& b) {
  return a.convex == b.convex && std::abs(a.turn_angle - b.turn_angle) < kMaxTurnDifference;
}

}  // namespace

std::vector<Hypothesis> hypotheses_from_corners(const LocalizationMap& map,
                                                std::span<const Feature> corners_base_link,
                                                std::span<const Point2> ends_base_link,
                                                const CornerHypothesisParams& params) {
  Places places(map, params);
  std::vector<Feature> corners(corners_base_link.begin(), corners_base_link.end());
  std::ranges::stable_sort(corners, std::ranges::greater{}, &Feature::count);
  if (corners.size() > params.max_corners) corners.resize(params.max_corners);
  std::size_t pairs = 0;
  for (const Feature& corner : corners) {
    const std::vector<Point2> judges = judges_of(corner, ends_base_link);
    for (const Feature& mapped : map.features()) {
      if (pairs == params.max_pairs) break;
      if (!may_be_same(corner, mapped)) continue;
      ++pairs;
      places.judge(pose_from(mapped, corner), judges);
    }
  }
  const std::vector<Point2> judges = thinned(within(ends_base_link, kCoarseReach), kJudges);
  for (const TriangleMatch& match :
       map.index().triangle_index.match(corners_base_link, {.max_trials = params.max_triangles,
                                                           .max_matches = kMaxTriangleMatches,
                                                           .seed = params.seed})) {
    places.judge(match.T_map_submap, judges);
  }
  return places.take();
}

}  // namespace cornerfix

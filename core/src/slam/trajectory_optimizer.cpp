#include <cornerfix/slam.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/src/local_map/scan_motion.hpp"
#include "core/src/slam/drive_submap.hpp"
#include "core/src/slam/loop_closer.hpp"
#include "core/src/slam/pose_graph.hpp"
#include "core/src/slam/submap_mosaic.hpp"

namespace cornerfix {
namespace {

// How lidar odometry drifts along the way.
constexpr double kDriftPerMetre = 0.05;
constexpr double kTurnPerMetre = 0.01;   // [rad/m]
constexpr double kLeastDrift = 1.0;      // [m]
constexpr double kLeastDriftTurn = 0.2;  // [rad]
constexpr double kClosedWay = 0.5;       // a loop closure drifts like as much way [m]

constexpr std::size_t kOverlapping = 3;    // submaps before a submap that are no older place
constexpr double kNeighborDistance = 4.0;  // ways nearer than this saw the same walls [m]
constexpr std::size_t kMaxNeighbors = 4;   // submaps that a closure or a keyframe is laid on
constexpr int kRounds = 2;                 // of laying keyframes on submaps
constexpr std::size_t kPointsPerScan = 180;

// Of keyframes in the submap that they made.
constexpr double kOwnSigmaM = 0.03;
constexpr double kOwnSigmaRad = 0.01;

double distance_to_way(const Point2& position, const DriveSubmap& submap) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Point2& p : submap.way) nearest = std::min(nearest, (p - position).norm());
  return nearest;
}

Error optimization_given_up() {
  return {ErrorCode::kUnavailable, "the optimisation of the trajectory was given up", ""};
}

/// Finds the poses of all submaps, one after the other.
class SubmapPlacer {
 public:
  explicit SubmapPlacer(std::span<const DriveSubmap> submaps) : submaps_(submaps) {}

  [[nodiscard]] Result<void> place_next() {
    const std::size_t k = graph_.poses.size();
    graph_.poses.push_back(predicted(k));
    if (k == 0) return {};
    graph_.relations.push_back(odometry(k));
    if (k < kOverlapping) return {};
    const std::size_t older = k - kOverlapping + 1;
    const SubmapMosaic mosaic(submaps_.first(older), std::span(graph_.poses).first(older));
    const auto place = find_place(submaps_[k], mosaic, graph_.poses[k], drift_to(k, older));
    if (!place || !is_confirmed(k, *place)) return {};
    return close(k, older, place->T_map_submap);
  }

  [[nodiscard]] const std::vector<Pose2>& poses() const { return graph_.poses; }
  [[nodiscard]] std::size_t closures() const { return closures_; }

 private:
  [[nodiscard]] Pose2 T_last_this(std::size_t k) const {
    return inverse(submaps_[k - 1].T_drive_submap) * submaps_[k].T_drive_submap;
  }

  [[nodiscard]] Pose2 predicted(std::size_t k) const {
    return k == 0 ? Pose2{} : graph_.poses[k - 1] * T_last_this(k);
  }

  [[nodiscard]] PoseRelation odometry(std::size_t k) const {
    const double way = std::hypot(T_last_this(k).x, T_last_this(k).y);
    return {.from = k - 1,
            .to = k,
            .T_from_to = T_last_this(k),
            .information = information_from(0.03 + 0.01 * way, 0.01 + 0.002 * way)};
  }

  /// Drift since any of the first `older` submaps was near, by the shortest way through the graph.
  [[nodiscard]] DriftBound drift_to(std::size_t k, std::size_t older) const {
    std::vector<double> ways(graph_.poses.size(), std::numeric_limits<double>::infinity());
    ways[k] = 0.0;
    // The graph is small and nearly a chain: relaxing it until nothing changes is quick.
    for (bool changed = true; changed;) {
      changed = false;
      for (const PoseRelation& relation : graph_.relations) {
        const double length = relation.may_be_wrong
                                  ? kClosedWay
                                  : std::hypot(relation.T_from_to.x, relation.T_from_to.y);
        for (const auto& [a, b] :
             {std::pair(relation.from, relation.to), std::pair(relation.to, relation.from)}) {
          if (ways[a] + length >= ways[b]) continue;
          ways[b] = ways[a] + length;
          changed = true;
        }
      }
    }
    double way = 0.0;
    for (std::size_t j = 0; j < older; ++j) {
      const double apart = distance(graph_.poses[j], graph_.poses[k]);
      if (apart < kLeastDrift + kDriftPerMetre * ways[j] + submaps_[j].reach_m)
        way = std::max(way, ways[j]);
    }
    return {kLeastDrift + kDriftPerMetre * way, kLeastDriftTurn + kTurnPerMetre * way};
  }

  /// A place that the drift does not explain must be found twice in a row.
  [[nodiscard]] bool is_confirmed(std::size_t k, const FoundPlace& place) {
    const auto last = std::exchange(far_place_, std::nullopt);
    if (place.is_near) return true;
    far_place_ = std::pair(k, place.T_map_submap);
    if (!last || last->first + 1 != k) return false;
    const Pose2 expected = last->second * T_last_this(k);
    return distance(expected, place.T_map_submap) < 0.5 &&
           angle_between(expected, place.T_map_submap) < 0.1;
  }

  [[nodiscard]] Result<void> close(std::size_t k, std::size_t older, const Pose2& T_map_submap) {
    std::vector<PoseRelation> found;
    for (std::size_t j = 0; j < older; ++j) {
      const Pose2 T_old_submap = inverse(graph_.poses[j]) * T_map_submap;
      if (distance_to_way(T_old_submap.translation(), submaps_[j]) > kNeighborDistance) continue;
      auto relation = relate(submaps_[k].evidence.ends, submaps_[j], T_old_submap);
      if (!relation) continue;
      relation->from = j;
      relation->to = k;
      found.push_back(*relation);
    }
    if (found.empty()) return {};
    ++closures_;
    graph_.relations.insert(graph_.relations.end(), found.begin(), found.end());
    graph_.poses[k] = T_map_submap;
    return optimize(graph_);
  }

  std::span<const DriveSubmap> submaps_;
  PoseGraph graph_;
  std::size_t closures_ = 0;
  std::optional<std::pair<std::size_t, Pose2>> far_place_;
};

/// Lays keyframes on the submaps around them and finds the poses of both.
class KeyFramePlacer {
 public:
  KeyFramePlacer(std::span<const PosedScan> drive, std::span<const DriveSubmap> submaps,
                 const std::vector<Pose2>& T_map_submap)
      : drive_(drive), submaps_(submaps) {
    graph_.poses = T_map_submap;
    graph_.poses.resize(submaps.size() + drive.size());
    for (std::size_t k = 0; k < submaps.size(); ++k) {
      const Pose2 T_submap_drive = inverse(submaps[k].T_drive_submap);
      for (std::size_t i = submaps[k].piece.first; i < submaps[k].piece.end; ++i) {
        const Pose2 T_submap_scan = T_submap_drive * drive[i].T_map_base_link;
        graph_.poses[submaps.size() + i] = graph_.poses[k] * T_submap_scan;
        own_.push_back({.from = k,
                        .to = submaps.size() + i,
                        .T_from_to = T_submap_scan,
                        .information = information_from(kOwnSigmaM, kOwnSigmaRad)});
      }
    }
  }

  /// Calls `progress` with the share of keyframes done.
  [[nodiscard]] Result<void> improve(const std::function<bool(double)>& progress) {
    graph_.relations = own_;
    for (std::size_t i = 0; i < drive_.size(); ++i) {
      relate_to_neighbors(i);
      if (!progress(static_cast<double>(i) / static_cast<double>(drive_.size())))
        return optimization_given_up();
    }
    return optimize(graph_);
  }

  [[nodiscard]] std::vector<Pose2> poses() const {
    return {graph_.poses.begin() + static_cast<std::ptrdiff_t>(submaps_.size()),
            graph_.poses.end()};
  }

 private:
  void relate_to_neighbors(std::size_t i) {
    const std::vector<Point2> points = near_points(drive_[i]);
    const Pose2& T_map_scan = graph_.poses[submaps_.size() + i];
    for (const std::size_t k : neighbors(i, T_map_scan)) {
      auto relation = relate(points, submaps_[k], inverse(graph_.poses[k]) * T_map_scan);
      if (!relation) continue;
      relation->from = k;
      relation->to = submaps_.size() + i;
      graph_.relations.push_back(*relation);
    }
  }

  [[nodiscard]] static std::vector<Point2> near_points(const PosedScan& scan) {
    std::vector<Point2> points = points_to_match(scan.scan, scan.T_base_link_laser);
    std::erase_if(points, [](const Point2& p) { return p.norm() > kSubmapRange; });
    return thinned(points, kPointsPerScan);
  }

  /// Submaps that the keyframe did not make and whose way passes near, nearest first.
  [[nodiscard]] std::vector<std::size_t> neighbors(std::size_t i, const Pose2& T_map_scan) const {
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t k = 0; k < submaps_.size(); ++k) {
      const DriveSubmap& submap = submaps_[k];
      if (submap.piece.first <= i && i < submap.piece.end) continue;
      if (distance(graph_.poses[k], T_map_scan) > submap.reach_m + kNeighborDistance) continue;
      const Pose2 T_submap_scan = inverse(graph_.poses[k]) * T_map_scan;
      const double apart = distance_to_way(T_submap_scan.translation(), submap);
      if (apart < kNeighborDistance) near.emplace_back(apart, k);
    }
    std::ranges::sort(near);
    std::vector<std::size_t> chosen;
    for (std::size_t n = 0; n < std::min(kMaxNeighbors, near.size()); ++n)
      chosen.push_back(near[n].second);
    return chosen;
  }

  std::span<const PosedScan> drive_;
  std::span<const DriveSubmap> submaps_;
  PoseGraph graph_;  ///< The submaps, then the keyframes.
  std::vector<PoseRelation> own_;
};

}  // namespace

Result<OptimizedTrajectory> optimize_trajectory(std::span<const PosedScan> drive,
                                                const std::function<bool(double)>& progress) {
  OptimizedTrajectory optimized;
  if (drive.empty()) return optimized;
  const auto goes_on = [&progress](double share) { return !progress || progress(share); };
  constexpr double kPlacingShare = 0.6;  // of the work

  const std::vector<DrivePiece> pieces = cut_drive(drive);
  std::vector<DriveSubmap> submaps;
  submaps.reserve(pieces.size());
  for (const DrivePiece piece : pieces) submaps.push_back(make_drive_submap(drive, piece));
  SubmapPlacer placer(submaps);
  for (std::size_t k = 0; k < submaps.size(); ++k) {
    if (auto placed = placer.place_next(); !placed) return placed.error();
    if (!goes_on(kPlacingShare * static_cast<double>(k + 1) / static_cast<double>(submaps.size())))
      return optimization_given_up();
  }
  KeyFramePlacer improver(drive, submaps, placer.poses());
  for (int round = 0; round < kRounds; ++round) {
    const auto improved = improver.improve([&](double share) {
      return goes_on(kPlacingShare + (1.0 - kPlacingShare) * (round + share) / kRounds);
    });
    if (!improved) return improved.error();
  }
  optimized.T_map_base_link = improver.poses();
  const Pose2 T_first_map = inverse(optimized.T_map_base_link.front());
  for (Pose2& pose : optimized.T_map_base_link) pose = T_first_map * pose;
  optimized.submaps = submaps.size();
  optimized.loop_closures = placer.closures();
  if (!goes_on(1.0)) return optimization_given_up();
  return optimized;
}

}  // namespace cornerfix

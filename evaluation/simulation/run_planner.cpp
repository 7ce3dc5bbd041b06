#include "evaluation/simulation/run_planner.hpp"

#include <cornerfix/occupancy_grid.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <random>
#include <utility>

namespace cornerfix::evaluation {

namespace {

constexpr double kLatticeSpacing = 0.1;     ///< [m] between neighbours of the lattice.
constexpr double kSmoothingReserve = 0.05;  ///< [m] the lattice keeps beyond the wanted clearance.
constexpr double kSeenRadius = 2.0;         ///< [m] about the path counts as visited.
constexpr double kMinLegLength = 5.0;       ///< [m] to the next goal, where the space allows.
constexpr int kGoalCandidates = 5;          ///< The nearest of these is driven to.
constexpr int kSmoothingRounds = 30;
constexpr double kTangentReach = 0.3;  ///< [m] ahead and behind, which the heading is taken over.

/// How far a point is from all that is not free, in every map. The path is planned in the frame
/// `grid` of the first, so that it does not depend on where that lies.
class FreeSpace {
 public:
  explicit FreeSpace(std::span<const OccupancyGrid* const> maps) {
    const Pose2 T_grid_map = inverse(maps.front()->T_map_grid);
    for (const OccupancyGrid* map : maps) {
      OccupancyGrid blocked = *map;
      blocked.T_map_grid = map == maps.front() ? Pose2{} : T_grid_map * map->T_map_grid;
      for (Cell& cell : blocked.cells) {
        if (cell != Cell::kFree) cell = Cell::kOccupied;
      }
      casters_.emplace_back(blocked);
    }
  }

  [[nodiscard]] double clearance(const Point2& point_grid) const {
    double clearance = std::numeric_limits<double>::infinity();
    for (const RayCaster& caster : casters_) {
      clearance = std::min(clearance, caster.clearance(point_grid));
    }
    return clearance;
  }

 private:
  std::vector<RayCaster> casters_;
};

struct Edge {
  int node = 0;
  double cost = 0.0;
};

/// Points of free space on a regular lattice, joined to their eight neighbours; paths through the
/// open cost less than paths along walls.
class Lattice {
 public:
  Lattice(const OccupancyGrid& map, const FreeSpace& space, double clearance_m)
      : spacing_(std::max(1.0, std::round(kLatticeSpacing / map.resolution)) * map.resolution),
        width_(static_cast<int>(map.width * map.resolution / spacing_)),
        height_(static_cast<int>(map.height * map.resolution / spacing_)) {
    clearance_.reserve(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    for (int node = 0; node < width_ * height_; ++node) {
      const double clearance = space.clearance(point(node));
      clearance_.push_back(clearance >= clearance_m ? clearance : 0.0);
    }
  }

  [[nodiscard]] int size() const { return width_ * height_; }
  [[nodiscard]] bool is_free(int node) const { return clearance(node) > 0.0; }

  /// In `grid`.
  [[nodiscard]] Point2 point(int node) const {
    const int row = node / width_;
    return {(node % width_ + 0.5) * spacing_, (row + 0.5) * spacing_};
  }

  void neighbors(int node, std::vector<Edge>& out) const {
    out.clear();
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = node % width_ + dx;
        const int y = node / width_ + dy;
        if ((dx == 0 && dy == 0) || x < 0 || y < 0 || x >= width_ || y >= height_) continue;
        const int other = y * width_ + x;
        if (!is_free(other)) continue;
        const double open = std::min(clearance(node), clearance(other));
        out.push_back({other, std::hypot(dx, dy) * spacing_ * (1.0 + 2.0 * std::exp(-open))});
      }
    }
  }

 private:
  [[nodiscard]] double clearance(int node) const {
    return clearance_[static_cast<std::size_t>(node)];
  }

  double spacing_;
  int width_;
  int height_;
  std::vector<double> clearance_;  ///< 0 where a robot does not fit.
};

std::vector<int> reachable_from(const Lattice& lattice, int start, std::vector<bool>& seen) {
  std::vector<int> nodes = {start};
  seen[static_cast<std::size_t>(start)] = true;
  std::vector<Edge> edges;
  for (std::size_t next = 0; next < nodes.size(); ++next) {
    lattice.neighbors(nodes[next], edges);
    for (const Edge& edge : edges) {
      if (seen[static_cast<std::size_t>(edge.node)]) continue;
      seen[static_cast<std::size_t>(edge.node)] = true;
      nodes.push_back(edge.node);
    }
  }
  return nodes;
}

/// Nodes of the largest connected space; empty where there is none.
std::vector<int> largest_space(const Lattice& lattice) {
  std::vector<bool> seen(static_cast<std::size_t>(lattice.size()), false);
  std::vector<int> largest;
  for (int node = 0; node < lattice.size(); ++node) {
    if (!lattice.is_free(node) || seen[static_cast<std::size_t>(node)]) continue;
    std::vector<int> space = reachable_from(lattice, node, seen);
    if (space.size() > largest.size()) largest = std::move(space);
  }
  return largest;
}

/// A*: the cheapest path between two connected nodes, both included.
std::vector<Point2> cheapest_path(const Lattice& lattice, int start, int goal) {
  const auto size = static_cast<std::size_t>(lattice.size());
  std::vector<double> cost(size, std::numeric_limits<double>::infinity());
  std::vector<int> previous(size, -1);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const Point2 goal_point = lattice.point(goal);
  const auto at_least = [&](int node) { return (lattice.point(node) - goal_point).norm(); };

  cost[static_cast<std::size_t>(start)] = 0.0;
  open.emplace(at_least(start), start);
  std::vector<Edge> edges;
  while (!open.empty() && open.top().second != goal) {
    const int node = open.top().second;
    open.pop();
    lattice.neighbors(node, edges);
    for (const Edge& edge : edges) {
      const auto to = static_cast<std::size_t>(edge.node);
      const double cost_to = cost[static_cast<std::size_t>(node)] + edge.cost;
      if (cost_to >= cost[to]) continue;
      cost[to] = cost_to;
      previous[to] = node;
      open.emplace(cost_to + at_least(edge.node), edge.node);
    }
  }
  std::vector<Point2> path;
  for (int node = goal; node >= 0; node = previous[static_cast<std::size_t>(node)]) {
    path.push_back(lattice.point(node));
  }
  std::reverse(path.begin(), path.end());
  return path;
}

/// Picks goals at random, but first where the robot has not been.
class GoalPicker {
 public:
  GoalPicker(const Lattice& lattice, std::vector<int> nodes, std::uint64_t seed)
      : lattice_(lattice), nodes_(std::move(nodes)), unvisited_(nodes_), random_(seed) {}

  int any() { return pick(nodes_); }

  /// The nearest of a few nodes that were not visited yet and are worth a run.
  int next(const Point2& from) {
    const auto is_worth_it = [&](int node) {
      return (lattice_.point(node) - from).norm() >= kMinLegLength;
    };
    std::vector<int> goals = filtered(unvisited_, is_worth_it);
    if (goals.empty()) {
      unvisited_ = nodes_;
      goals = filtered(nodes_, is_worth_it);
    }
    if (goals.empty()) return farthest(from);
    int best = pick(goals);
    for (int i = 1; i < kGoalCandidates; ++i) {
      const int other = pick(goals);
      if ((lattice_.point(other) - from).norm() < (lattice_.point(best) - from).norm()) {
        best = other;
      }
    }
    return best;
  }

  void visit(std::span<const Point2> path) {
    // Points nearer than a fraction of the radius add nothing.
    std::vector<Point2> sparse;
    for (const Point2& point : path) {
      if (sparse.empty() || (point - sparse.back()).norm() > 0.25 * kSeenRadius) {
        sparse.push_back(point);
      }
    }
    unvisited_ = filtered(unvisited_, [&](int node) {
      const Point2 point = lattice_.point(node);
      return std::none_of(sparse.begin(), sparse.end(), [&](const Point2& visited) {
        return (visited - point).squaredNorm() < kSeenRadius * kSeenRadius;
      });
    });
  }

 private:
  template <typename Predicate>
  static std::vector<int> filtered(const std::vector<int>& nodes, Predicate keep) {
    std::vector<int> kept;
    std::copy_if(nodes.begin(), nodes.end(), std::back_inserter(kept), keep);
    return kept;
  }

  int pick(const std::vector<int>& nodes) {
    return nodes[std::uniform_int_distribution<std::size_t>(0, nodes.size() - 1)(random_)];
  }

  [[nodiscard]] int farthest(const Point2& from) const {
    return *std::max_element(nodes_.begin(), nodes_.end(), [&](int a, int b) {
      return (lattice_.point(a) - from).norm() < (lattice_.point(b) - from).norm();
    });
  }

  const Lattice& lattice_;
  std::vector<int> nodes_;
  std::vector<int> unvisited_;
  std::mt19937_64 random_;
};

/// Pulls the corners of a path straight as far as the clearance allows; its ends stay.
void smooth(std::vector<Point2>& path, const FreeSpace& space, double clearance_m) {
  for (int round = 0; round < kSmoothingRounds; ++round) {
    for (std::size_t i = 1; i + 1 < path.size(); ++i) {
      const Point2 pulled = 0.5 * path[i] + 0.25 * (path[i - 1] + path[i + 1]);
      if (space.clearance(pulled) >= clearance_m) path[i] = pulled;
    }
  }
}

/// A polyline by the length along it.
class Polyline {
 public:
  explicit Polyline(std::vector<Point2> points) : points_(std::move(points)), lengths_{0.0} {
    for (std::size_t i = 1; i < points_.size(); ++i) {
      lengths_.push_back(lengths_.back() + (points_[i] - points_[i - 1]).norm());
    }
  }

  [[nodiscard]] double length() const { return lengths_.back(); }

  /// Lengths beyond an end give that end.
  [[nodiscard]] Point2 at(double length) const {
    const auto after = std::upper_bound(lengths_.begin(), lengths_.end(), length);
    if (after == lengths_.begin()) return points_.front();
    if (after == lengths_.end()) return points_.back();
    const auto i = static_cast<std::size_t>(after - lengths_.begin());
    const double share = (length - lengths_[i - 1]) / (lengths_[i] - lengths_[i - 1]);
    return points_[i - 1] + share * (points_[i] - points_[i - 1]);
  }

  [[nodiscard]] double heading_at(double length) const {
    const Point2 tangent = at(length + kTangentReach) - at(length - kTangentReach);
    return std::atan2(tangent.y(), tangent.x());
  }

 private:
  std::vector<Point2> points_;
  std::vector<double> lengths_;
};

/// Adds a pose, and before it the turn on the spot that it takes to face along the path.
void append_turning(std::vector<Pose2>& poses, const Pose2& pose, double max_turn_rad) {
  while (!poses.empty()) {
    const Pose2& last = poses.back();
    const double turn = wrap_angle(pose.yaw - last.yaw);
    if (std::abs(turn) <= max_turn_rad) break;
    poses.push_back({last.x, last.y, wrap_angle(last.yaw + std::copysign(max_turn_rad, turn))});
  }
  poses.push_back(pose);
}

}  // namespace

Result<std::vector<Pose2>> plan_run(std::span<const OccupancyGrid* const> maps,
                                    const RunPlanOptions& options) {
  assert(!maps.empty() && "there is a map to plan in");
  const FreeSpace space(maps);
  const Lattice lattice(*maps.front(), space, options.clearance_m + kSmoothingReserve);
  std::vector<int> nodes = largest_space(lattice);
  if (nodes.size() < 2) {
    return Error{ErrorCode::kInvalidArgument, "no free space is wide enough to drive in", "map"};
  }
  GoalPicker goals(lattice, std::move(nodes), options.seed);

  std::vector<Pose2> poses;
  int at = goals.any();
  for (double driven = 0.0; driven < options.length_m;) {
    const int goal = goals.next(lattice.point(at));
    std::vector<Point2> path = cheapest_path(lattice, at, goal);
    smooth(path, space, options.clearance_m);
    goals.visit(path);
    const Polyline leg(std::move(path));
    const double leg_length = std::min(leg.length(), options.length_m - driven);
    for (double length = 0.0; length <= leg_length; length += options.step_m) {
      const Point2 point = leg.at(length);
      append_turning(poses, {point.x(), point.y(), leg.heading_at(length)}, options.max_turn_rad);
    }
    driven += leg.length();
    at = goal;
  }
  for (Pose2& pose : poses) pose = maps.front()->T_map_grid * pose;
  return poses;
}

}  // namespace cornerfix::evaluation

#include "bench/rivals/branch_and_bound.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <unordered_set>

namespace cornerfix::bench {
namespace {

struct CellOffset {
  int column = 0;
  int row = 0;
};

/// Turning by this moves the farthest point by one cell (eq. 7).
double angular_step(std::span<const Point2> points, double resolution) {
  double reach = 3.0 * resolution;
  for (const Point2& point : points) reach = std::max(reach, point.norm());
  return std::acos(1.0 - resolution * resolution / (2.0 * reach * reach));
}

std::vector<Point2> one_a_cell(std::span<const Point2> points, double length_m) {
  std::unordered_set<std::uint64_t> taken;
  std::vector<Point2> thinned;
  for (const Point2& point : points) {
    const auto column = static_cast<std::int32_t>(std::floor(point.x() / length_m));
    const auto row = static_cast<std::int32_t>(std::floor(point.y() / length_m));
    const std::uint64_t key =
        (static_cast<std::uint64_t>(static_cast<std::uint32_t>(column)) << 32) |
        static_cast<std::uint32_t>(row);
    if (taken.insert(key).second) thinned.push_back(point);
  }
  return thinned;
}

}  // namespace

/// The points of the scan turned to one heading, as cells about the robot, and where the robot may
/// then be.
struct BranchAndBoundMatcher::Rotation {
  double yaw = 0.0;
  std::vector<CellOffset> points;
};

/// A block of 2^level cells to the upper right of a robot's cell, at one heading.
struct BranchAndBoundMatcher::Candidate {
  const Rotation* rotation = nullptr;
  int column = 0;
  int row = 0;
  int score = 0;  ///< Sum of values: a bound for all of the block.
};

struct BranchAndBoundMatcher::Search {
  const BranchAndBoundMatcher& matcher;
  int max_column = 0;  ///< Of the window.
  int max_row = 0;

  [[nodiscard]] int score(const Candidate& candidate, int level) const {
    const Level& values = matcher.levels_[static_cast<std::size_t>(level)];
    int sum = 0;
    for (const CellOffset& point : candidate.rotation->points) {
      sum += values.at(candidate.column + point.column, candidate.row + point.row);
    }
    return sum;
  }

  /// Algorithm 3: depth first, the best block first. `best.score` is the bound to beat.
  void descend(std::vector<Candidate>& candidates, int level, Candidate& best) const {
    std::ranges::sort(candidates, std::greater{}, &Candidate::score);
    if (level == 0) {
      if (!candidates.empty() && candidates.front().score > best.score) best = candidates.front();
      return;
    }
    for (const Candidate& candidate : candidates) {
      if (candidate.score <= best.score) return;
      std::vector<Candidate> parts;
      const int half = 1 << (level - 1);
      for (const int x : {0, half}) {
        for (const int y : {0, half}) {
          Candidate part{candidate.rotation, candidate.column + x, candidate.row + y, 0};
          if (part.column > max_column || part.row > max_row) continue;
          part.score = score(part, level - 1);
          parts.push_back(part);
        }
      }
      descend(parts, level - 1, best);
    }
  }
};

BranchAndBoundMatcher::BranchAndBoundMatcher(const ProbabilityGrid& grid, int depth)
    : resolution_(grid.resolution),
      origin_map_(grid.origin_map),
      width_(grid.width),
      height_(grid.height) {
  assert(depth >= 1 && "no pyramid without a level");
  levels_.push_back({0, grid.width, grid.height, grid.values});
  for (int level = 1; level < depth; ++level) {
    const Level& below = levels_.back();
    const int half = 1 << (level - 1);
    Level next{2 * half - 1, width_ + 2 * half - 1, height_ + 2 * half - 1, {}};
    next.values.reserve(static_cast<std::size_t>(next.width) *
                        static_cast<std::size_t>(next.height));
    for (int row = -next.margin; row < height_; ++row) {
      for (int column = -next.margin; column < width_; ++column) {
        next.values.push_back(
            std::max({below.at(column, row), below.at(column + half, row),
                      below.at(column, row + half), below.at(column + half, row + half)}));
      }
    }
    levels_.push_back(std::move(next));
  }
}

std::size_t BranchAndBoundMatcher::bytes() const {
  std::size_t sum = 0;
  for (const Level& level : levels_) sum += level.values.size();
  return sum;
}

std::optional<ScanMatch> BranchAndBoundMatcher::match(std::span<const Point2> points_base_link,
                                                      const SearchWindow& window,
                                                      double min_score) const {
  if (points_base_link.empty() || width_ == 0) return std::nullopt;
  const double step = angular_step(points_base_link, resolution_);
  const int turns = static_cast<int>(std::ceil(window.angle_rad / step));
  std::vector<Rotation> rotations;
  for (int turn = -turns; turn <= turns; ++turn) {
    Rotation rotation{wrap_angle(window.T_map_base_link.yaw + turn * step), {}};
    const Pose2 T_turned{0.0, 0.0, rotation.yaw};
    for (const Point2& point : points_base_link) {
      const Point2 turned = T_turned * point;
      rotation.points.push_back({static_cast<int>(std::lround(turned.x() / resolution_)),
                                 static_cast<int>(std::lround(turned.y() / resolution_))});
    }
    rotations.push_back(std::move(rotation));
  }
  const Point2 center = (window.T_map_base_link.translation() - origin_map_) / resolution_;
  const double reach = window.distance_m / resolution_;
  const auto lowest = [&](double at) {
    return static_cast<int>(std::max(0.0, std::floor(at - reach)));
  };
  const auto highest = [&](double at, int size) {
    return static_cast<int>(std::min(size - 1.0, std::floor(at + reach)));
  };
  const Search search{*this, highest(center.x(), width_), highest(center.y(), height_)};
  const int top = static_cast<int>(levels_.size()) - 1;
  std::vector<Candidate> candidates;
  for (const Rotation& rotation : rotations) {
    for (int row = lowest(center.y()); row <= search.max_row; row += 1 << top) {
      for (int column = lowest(center.x()); column <= search.max_column; column += 1 << top) {
        candidates.push_back({&rotation, column, row, 0});
        candidates.back().score = search.score(candidates.back(), top);
      }
    }
  }
  const auto points = static_cast<double>(points_base_link.size());
  const double threshold = (min_score - ProbabilityGrid::kMin) /
                           (ProbabilityGrid::kMax - ProbabilityGrid::kMin) * 255.0 * points;
  Candidate best{nullptr, 0, 0, static_cast<int>(std::floor(threshold))};
  search.descend(candidates, top, best);
  if (best.rotation == nullptr) return std::nullopt;
  const Point2 position = origin_map_ + resolution_ * Point2(best.column + 0.5, best.row + 0.5);
  return ScanMatch{{position.x(), position.y(), best.rotation->yaw},
                   ProbabilityGrid::probability(best.score / points)};
}

std::vector<Point2> thin_adaptively(std::span<const Point2> points, std::size_t min_points,
                                    double max_length_m) {
  std::vector<Point2> thinned = one_a_cell(points, max_length_m);
  if (thinned.size() >= min_points) return thinned;
  if (points.size() <= min_points) return {points.begin(), points.end()};
  double high = max_length_m;  // too few points are left
  double low = 0.01;
  thinned = one_a_cell(points, low);
  while (high - low > 0.1 * low) {
    const double middle = 0.5 * (low + high);
    std::vector<Point2> attempt = one_a_cell(points, middle);
    if (attempt.size() >= min_points) {
      low = middle;
      thinned = std::move(attempt);
    } else {
      high = middle;
    }
  }
  return thinned;
}

}  // namespace cornerfix::bench

#include "evaluation/metrics/revisit_score.hpp"

#include <algorithm>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>

#include "evaluation/metrics/scan_registration.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLeastPathLength = 20.0;  // [m]
constexpr double kNear = 1.5;              // [m]
constexpr double kSameDirection = 40.0 * kDegree;
constexpr std::size_t kMaxPairs = 500;
constexpr double kSamePosition = 0.01;  // [m]
constexpr double kSameHeading = 0.2 * kDegree;
constexpr double kLeastShare = 0.3;   // of a scan's points on walls of the other
constexpr double kClearlyMore = 0.1;  // of them

struct ScanPair {
  std::size_t later = 0;
  std::size_t earlier = 0;

  [[nodiscard]] Pose2 in(const std::vector<Pose2>& trajectory) const {
    return inverse(trajectory[earlier]) * trajectory[later];
  }
};

std::vector<ScanPair> revisits(std::span<const std::size_t> indices,
                               const std::vector<Pose2>& trajectory) {
  std::vector<double> path_lengths_m(indices.size(), 0.0);
  std::vector<ScanPair> pairs;
  for (std::size_t n = 1; n < indices.size(); ++n) {
    const Pose2& here = trajectory[indices[n]];
    path_lengths_m[n] = path_lengths_m[n - 1] + distance(trajectory[indices[n - 1]], here);
    double nearest = kNear;
    std::optional<std::size_t> back;
    for (std::size_t m = 0; m < n && path_lengths_m[m] + kLeastPathLength <= path_lengths_m[n];
         ++m) {
      const Pose2& there = trajectory[indices[m]];
      if (distance(here, there) >= nearest || angle_between(here, there) > kSameDirection) continue;
      nearest = distance(here, there);
      back = indices[m];
    }
    if (back) pairs.push_back({indices[n], *back});
  }
  return pairs;
}

/// Of all trajectories, evenly taken.
std::vector<ScanPair> all_revisits(std::span<const std::size_t> indices,
                                   std::span<const std::vector<Pose2>> trajectories) {
  std::vector<ScanPair> pairs;
  for (const std::vector<Pose2>& trajectory : trajectories)
    std::ranges::copy(revisits(indices, trajectory), std::back_inserter(pairs));
  const auto indices_of = [](const ScanPair& pair) { return std::pair(pair.later, pair.earlier); };
  const auto is_same_pair = [&](const ScanPair& a, const ScanPair& b) {
    return indices_of(a) == indices_of(b);
  };
  std::ranges::sort(pairs, {}, indices_of);
  pairs.erase(std::unique(pairs.begin(), pairs.end(), is_same_pair), pairs.end());
  if (pairs.size() <= kMaxPairs) return pairs;
  std::vector<ScanPair> thinned;
  for (std::size_t i = 0; i < kMaxPairs; ++i)
    thinned.push_back(pairs[i * pairs.size() / kMaxPairs]);
  return thinned;
}

bool is_same(const Pose2& a, const Pose2& b) {
  return distance(a, b) <= kSamePosition && angle_between(a, b) <= kSameHeading;
}

/// What the two scans say, wherever one begins to lay them on each other.
std::optional<Pose2> registered(std::span<const LogScan> scans, const ScanPair& pair,
                                std::span<const std::vector<Pose2>> trajectories) {
  std::vector<Registration> found;
  for (const std::vector<Pose2>& trajectory : trajectories) {
    const auto from_here =
        register_scans(scans[pair.earlier].scan, scans[pair.later].scan, pair.in(trajectory));
    if (from_here && from_here->inlier_share >= kLeastShare) found.push_back(*from_here);
  }
  if (found.empty()) return std::nullopt;
  const Registration& best = *std::ranges::max_element(found, {}, &Registration::inlier_share);
  const bool is_contested = std::ranges::any_of(found, [&](const Registration& other) {
    return !is_same(best.T_a_b, other.T_a_b) &&
           other.inlier_share + kClearlyMore > best.inlier_share;
  });
  if (is_contested) return std::nullopt;
  return best.T_a_b;
}

}  // namespace

RevisitScore score_revisits(std::span<const LogScan> scans, std::span<const std::size_t> indices,
                            std::span<const std::vector<Pose2>> trajectories) {
  RevisitScore score;
  score.errors.resize(trajectories.size(),
                      {.path_length_m = kLeastPathLength, .errors_m = {}, .errors_rad = {}});
  for (const ScanPair& pair : all_revisits(indices, trajectories)) {
    const auto expected = registered(scans, pair, trajectories);
    if (!expected) {
      ++score.undecided;
      continue;
    }
    ++score.pairs;
    for (std::size_t i = 0; i < trajectories.size(); ++i) {
      const Pose2 found = pair.in(trajectories[i]);
      score.errors[i].errors_m.push_back(distance(*expected, found));
      score.errors[i].errors_rad.push_back(angle_between(*expected, found));
    }
  }
  return score;
}

}  // namespace cornerfix::evaluation

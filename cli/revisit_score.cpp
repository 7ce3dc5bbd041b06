#include "cli/revisit_score.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "cli/scan_registration.hpp"

namespace cornerfix::cli {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLeastWay = 20.0;  // [m]
constexpr double kNear = 1.5;       // [m]
constexpr double kSameWay = 40.0 * kDegree;
constexpr std::size_t kMaxPairs = 1000;
constexpr double kSamePosition = 0.01;  // [m]
constexpr double kSameHeading = 0.2 * kDegree;

struct ScanPair {
  std::size_t earlier = 0;
  std::size_t later = 0;

  [[nodiscard]] Pose2 in(const std::vector<Pose2>& trajectory) const {
    return inverse(trajectory[earlier]) * trajectory[later];
  }
};

std::vector<ScanPair> revisits(std::span<const std::size_t> indices,
                               const std::vector<Pose2>& trajectory) {
  std::vector<double> ways(indices.size(), 0.0);
  std::vector<ScanPair> pairs;
  for (std::size_t n = 1; n < indices.size(); ++n) {
    const Pose2& here = trajectory[indices[n]];
    ways[n] = ways[n - 1] + distance(trajectory[indices[n - 1]], here);
    double nearest = kNear;
    std::optional<std::size_t> back;
    for (std::size_t m = 0; m < n && ways[m] + kLeastWay <= ways[n]; ++m) {
      const Pose2& there = trajectory[indices[m]];
      if (distance(here, there) >= nearest || angle_between(here, there) > kSameWay) continue;
      nearest = distance(here, there);
      back = indices[m];
    }
    if (back) pairs.push_back({*back, indices[n]});
  }
  return pairs;
}

std::vector<ScanPair> thinned(const std::vector<ScanPair>& pairs) {
  if (pairs.size() <= kMaxPairs) return pairs;
  std::vector<ScanPair> kept;
  for (std::size_t i = 0; i < kMaxPairs; ++i) kept.push_back(pairs[i * pairs.size() / kMaxPairs]);
  return kept;
}

/// What the two scans say, if it is the same whichever trajectory is asked where to begin.
std::optional<Pose2> registered(std::span<const LogScan> scans, const ScanPair& pair,
                                std::span<const std::vector<Pose2>> trajectories) {
  std::optional<Pose2> agreed;
  for (const std::vector<Pose2>& trajectory : trajectories) {
    const auto found =
        register_scans(scans[pair.earlier].scan, scans[pair.later].scan, pair.in(trajectory));
    if (!found) return std::nullopt;
    if (agreed && (distance(*agreed, *found) > kSamePosition ||
                   angle_between(*agreed, *found) > kSameHeading))
      return std::nullopt;
    agreed = found;
  }
  return agreed;
}

}  // namespace

std::vector<RelativePoseError> revisit_errors(std::span<const LogScan> scans,
                                              std::span<const std::size_t> indices,
                                              std::span<const std::vector<Pose2>> trajectories) {
  std::vector<RelativePoseError> errors(trajectories.size(),
                                        {.way_m = kLeastWay, .errors_m = {}, .errors_rad = {}});
  for (const ScanPair& pair : thinned(revisits(indices, trajectories.front()))) {
    const auto expected = registered(scans, pair, trajectories);
    if (!expected) continue;
    for (std::size_t i = 0; i < trajectories.size(); ++i) {
      const Pose2 found = pair.in(trajectories[i]);
      errors[i].errors_m.push_back(distance(*expected, found));
      errors[i].errors_rad.push_back(angle_between(*expected, found));
    }
  }
  return errors;
}

}  // namespace cornerfix::cli

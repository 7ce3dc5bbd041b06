#include "core/src/search/corner_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace cornerfix {
namespace {

constexpr double kDistanceTolerance = 0.2;  // [m]
constexpr double kAngleTolerance = 0.12;    // [rad]
constexpr double kAngleStep = 2.0 * std::numbers::pi / kPairAngles;

std::size_t distance_class(double distance_m) {
  const double at = (distance_m - kMinPairDistance) / kPairDistanceStep;
  return static_cast<std::size_t>(std::clamp(at, 0.0, kPairDistances - 1.0));
}

std::size_t angle_class(double angle) {
  const auto at = static_cast<int>(std::floor(angle / kAngleStep));
  constexpr auto kClasses = static_cast<int>(kPairAngles);
  return static_cast<std::size_t>(((at % kClasses) + kClasses) % kClasses);
}

std::size_t key_of_classes(std::size_t distance, std::size_t first, std::size_t second,
                           const CornerPair& pair) {
  const std::size_t senses = (pair.first_convex ? 1U : 0U) + (pair.second_convex ? 2U : 0U);
  return ((distance * kPairAngles + first) * kPairAngles + second) * 4 + senses;
}

/// The classes of the ends of an interval, once if they are one. It is narrower than a class.
template <typename ClassOf>
std::pair<std::array<std::size_t, 2>, std::size_t> classes_within(double value, double tolerance,
                                                                  const ClassOf& class_of) {
  const std::array<std::size_t, 2> ends{class_of(value - tolerance), class_of(value + tolerance)};
  return {ends, ends[0] == ends[1] ? 1 : 2};
}

}  // namespace

std::optional<CornerPair> corner_pair(const OrientedCorner& first, const OrientedCorner& second) {
  const Point2 line = second.position - first.position;
  const double distance_m = line.norm();
  if (distance_m < kMinPairDistance || distance_m > kMaxPairDistance) return std::nullopt;
  const double direction = std::atan2(line.y(), line.x());
  return CornerPair{distance_m,
                    wrap_angle(first.bisector - direction),
                    wrap_angle(second.bisector - direction),
                    first.convex,
                    second.convex,
                    {first.position.x(), first.position.y(), direction}};
}

std::size_t key_of(const CornerPair& pair) {
  return key_of_classes(distance_class(pair.distance_m), angle_class(pair.first_angle),
                        angle_class(pair.second_angle), pair);
}

void keys_near(const CornerPair& pair, std::vector<std::size_t>& keys) {
  const auto [distances, distance_count] =
      classes_within(pair.distance_m, kDistanceTolerance, distance_class);
  const auto [firsts, first_count] = classes_within(pair.first_angle, kAngleTolerance, angle_class);
  const auto [seconds, second_count] =
      classes_within(pair.second_angle, kAngleTolerance, angle_class);
  for (std::size_t d = 0; d < distance_count; ++d) {
    for (std::size_t i = 0; i < first_count; ++i) {
      for (std::size_t j = 0; j < second_count; ++j)
        keys.push_back(key_of_classes(distances[d], firsts[i], seconds[j], pair));
    }
  }
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> neighboring_pairs(
    std::span<const SketchCorner> corners, std::size_t max_neighbors) {
  using Neighbor = std::pair<float, std::uint32_t>;  // squared distance, corner
  constexpr auto kLeast = static_cast<float>(kMinPairDistance * kMinPairDistance);
  constexpr auto kMost = static_cast<float>(kMaxPairDistance * kMaxPairDistance);
  std::vector<std::uint32_t> by_x(corners.size());
  for (std::uint32_t i = 0; i < by_x.size(); ++i) by_x[i] = i;
  std::ranges::sort(by_x, {}, [&](std::uint32_t i) { return std::pair(corners[i].x, i); });
  std::vector<std::vector<Neighbor>> nearest(corners.size());
  std::vector<Neighbor> near;
  for (std::size_t at = 0; at < by_x.size(); ++at) {
    const SketchCorner& corner = corners[by_x[at]];
    near.clear();
    const auto look = [&](std::size_t other) {
      const float dx = corners[by_x[other]].x - corner.x;
      const float dy = corners[by_x[other]].y - corner.y;
      const float squared = dx * dx + dy * dy;
      if (squared >= kLeast && squared <= kMost) near.emplace_back(squared, by_x[other]);
      return std::abs(dx) <= static_cast<float>(kMaxPairDistance);
    };
    for (std::size_t other = at; other-- > 0 && look(other);) continue;
    for (std::size_t other = at + 1; other < by_x.size() && look(other); ++other) continue;
    const std::size_t kept = std::min(max_neighbors, near.size());
    const auto end = near.begin() + static_cast<std::ptrdiff_t>(kept);
    if (kept < near.size()) std::ranges::nth_element(near, end);
    nearest[by_x[at]].assign(near.begin(), end);
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::uint32_t i = 0; i < corners.size(); ++i) {
    for (const auto& [squared, other] : nearest[i]) {
      // A pair that each has of the other comes from its first corner.
      const bool is_mutual =
          std::ranges::find(nearest[other], i, &Neighbor::second) != nearest[other].end();
      if (i < other || !is_mutual) pairs.push_back(std::minmax(i, other));
    }
  }
  return pairs;
}

}  // namespace cornerfix

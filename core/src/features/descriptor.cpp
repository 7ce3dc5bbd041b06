#include <cornerfix/corners.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

namespace cornerfix {
namespace {

constexpr double kFullTurn = 2.0 * std::numbers::pi;
constexpr double kMaxBins = std::numeric_limits<std::uint16_t>::max();
constexpr double kMaxAngleBins = 4096.0;
// Of one set: about 0.5 GB. 15,000 features at 0.5 features/m2 stay below.
constexpr double kMaxEntries = 6e7;

/// Two features within reach of each other; the bearing is that from each to the other.
struct NearPair {
  std::uint32_t first = 0;
  std::uint32_t second = 0;
  std::uint16_t distance_bin = 0;
  std::uint16_t first_angle_bin = 0;
  std::uint16_t second_angle_bin = 0;
};

/// Eqs. (10), (12) and (13). A bearing that rounds up to a full turn is bin 0.
class Quantiser {
 public:
  Quantiser(const DescriptorParams& params, int angle_bins)
      : distance_resolution_(params.distance_resolution_m),
        angle_resolution_(kFullTurn / angle_bins),
        angle_bins_(angle_bins) {}

  [[nodiscard]] NearPair operator()(std::uint32_t first, std::uint32_t second, const Point2& v,
                                    double distance) const {
    const double bearing = std::atan2(v.y(), v.x());
    return {first, second, static_cast<std::uint16_t>(std::lround(distance / distance_resolution_)),
            angle_bin(bearing < 0.0 ? bearing + kFullTurn : bearing),
            angle_bin(bearing + std::numbers::pi)};
  }

 private:
  [[nodiscard]] std::uint16_t angle_bin(double angle) const {
    return static_cast<std::uint16_t>(std::lround(angle / angle_resolution_) % angle_bins_);
  }

  double distance_resolution_;
  double angle_resolution_;
  int angle_bins_;
};

/// Calls `visit(first, second, v, distance)` for all pairs within reach, always in the same order:
/// by a sweep along x, so that a large map costs no n^2.
template <typename Visit>
void for_each_near_pair(std::span<const Feature> features, double max_distance_m,
                        const Visit& visit) {
  std::vector<std::uint32_t> by_x(features.size());
  std::iota(by_x.begin(), by_x.end(), 0U);
  const auto x_of = [&](std::uint32_t i) { return features[i].position.x(); };
  std::ranges::stable_sort(by_x, {}, x_of);
  for (std::size_t i = 0; i < by_x.size(); ++i) {
    const Point2 p = features[by_x[i]].position;
    for (std::size_t j = i + 1; j < by_x.size(); ++j) {
      const Point2 v = features[by_x[j]].position - p;
      if (v.x() > max_distance_m) break;
      const double distance = v.norm();
      if (distance <= max_distance_m) visit(by_x[i], by_x[j], v, distance);
    }
  }
}

/// Features by squares of `side_m`, and for each one those of its own and the eight squares about:
/// no fewer than the entries of describe() where max_distance_m is `side_m`.
double most_entries(std::span<const Feature> features, double side_m) {
  using Square = std::pair<std::int64_t, std::int64_t>;
  const auto index = [&](double coordinate) {
    return static_cast<std::int64_t>(std::floor(coordinate / side_m));
  };
  std::vector<Square> squares;
  squares.reserve(features.size());
  for (const Feature& feature : features)
    squares.emplace_back(index(feature.position.x()), index(feature.position.y()));
  std::ranges::sort(squares);
  double entries = 0.0;
  for (auto begin = squares.begin(); begin != squares.end();) {
    const auto end = std::upper_bound(begin, squares.end(), *begin);
    std::ptrdiff_t near = 0;
    for (const int column : {-1, 0, 1}) {
      // Squares of a column follow each other.
      const Square first{begin->first + column, begin->second - 1};
      const Square last{begin->first + column, begin->second + 1};
      near += std::ranges::upper_bound(squares, last) - std::ranges::lower_bound(squares, first);
    }
    entries += static_cast<double>(end - begin) * static_cast<double>(near);
    begin = end;
  }
  return entries;
}

/// The wanted distance, or a shorter one that keeps the entries within kMaxEntries.
double affordable_distance(std::span<const Feature> features, double wanted_m) {
  constexpr int kMostHalvings = 30;
  const auto count = static_cast<double>(features.size());
  if (count * count <= kMaxEntries) return wanted_m;
  double distance_m = wanted_m;
  for (int i = 0; i < kMostHalvings; ++i) {
    if (most_entries(features, distance_m) <= kMaxEntries) break;
    distance_m *= 0.5;
  }
  return distance_m;
}

/// Turns counts into begins, in place.
template <typename Integer>
void to_offsets(std::vector<Integer>& counts) {
  std::exclusive_scan(counts.begin(), counts.end(), counts.begin(), Integer{0});
}

}  // namespace

int angle_bins(const DescriptorParams& params) {
  return static_cast<int>(std::lround(kFullTurn / params.angle_resolution_rad));
}

std::optional<Error> validate(const DescriptorParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!(params.distance_resolution_m > 0.0) || !std::isfinite(params.distance_resolution_m)) {
    return broken("distance_resolution_m", "must be a finite length in metres above 0");
  }
  const double angle_bins = kFullTurn / params.angle_resolution_rad;
  if (!(angle_bins >= 1.0 && angle_bins <= kMaxAngleBins &&
        std::abs(angle_bins - std::round(angle_bins)) < 1e-6)) {
    return broken("angle_resolution_rad", "must divide a full turn into 1 to 4096 parts");
  }
  if (!(params.max_distance_m > 0.0 &&
        params.max_distance_m / params.distance_resolution_m < kMaxBins)) {
    return broken("max_distance_m", "must be above 0 m and below 65535 distance_resolution_m");
  }
  return std::nullopt;
}

DescriptorSet describe(std::span<const Feature> features, const DescriptorParams& params) {
  assert(!validate(params) && "params must pass validate()");
  DescriptorSet set;
  set.params = params;
  set.params.max_distance_m = affordable_distance(features, params.max_distance_m);
  // Pairs are found twice: to keep them would take more memory than the descriptors.
  set.offsets.assign(features.size() + 1, 0);
  for_each_near_pair(features, set.params.max_distance_m,
                     [&](std::uint32_t first, std::uint32_t second, const Point2&, double) {
                       ++set.offsets[first];
                       ++set.offsets[second];
                     });
  to_offsets(set.offsets);
  set.entries.resize(set.offsets.back());
  std::vector<std::uint32_t> next = set.offsets;
  const Quantiser quantise(set.params, set.angle_bins());
  for_each_near_pair(
      features, set.params.max_distance_m,
      [&](std::uint32_t first, std::uint32_t second, const Point2& v, double distance) {
        const NearPair pair = quantise(first, second, v, distance);
        set.entries[next[first]++] = {pair.distance_bin, pair.first_angle_bin, second};
        set.entries[next[second]++] = {pair.distance_bin, pair.second_angle_bin, first};
      });
  const std::span all(set.entries);
  for (std::size_t feature = 0; feature < features.size(); ++feature) {
    const std::uint32_t begin = set.offsets[feature];
    std::ranges::stable_sort(all.subspan(begin, set.offsets[feature + 1] - begin), {},
                             &DescriptorEntry::distance_bin);
  }
  return set;
}

std::vector<DescriptorEntry> describe_one(std::span<const Feature> features, std::size_t feature,
                                          const DescriptorParams& params) {
  assert(!validate(params) && "params must pass validate()");
  const Quantiser quantise(params, angle_bins(params));
  const Point2 self = features[feature].position;
  std::vector<DescriptorEntry> entries;
  for (std::size_t other = 0; other < features.size(); ++other) {
    const Point2 v = features[other].position - self;
    const double distance = v.norm();
    if (other == feature || distance > params.max_distance_m) continue;
    // Of a pair, the bearing is measured at the feature with the smaller x and turned for the
    // other.
    const auto id = static_cast<std::uint32_t>(other);
    const bool is_first = v.x() > 0.0 || (v.x() == 0.0 && feature < other);
    const NearPair pair = quantise(0, 0, is_first ? v : Point2(-v), distance);
    entries.push_back(
        {pair.distance_bin, is_first ? pair.first_angle_bin : pair.second_angle_bin, id});
  }
  std::ranges::stable_sort(entries, {}, &DescriptorEntry::distance_bin);
  return entries;
}

}  // namespace cornerfix

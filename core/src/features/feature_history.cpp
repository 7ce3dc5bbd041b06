#include "core/src/features/feature_history.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <utility>

namespace cornerfix {

namespace {

constexpr int kLooksToForget = 10;     // a corner that stands is found in one scan of two or three
constexpr double kMaxDistance = 10.0;  // from which a scan is expected to show a corner [m]
constexpr double kMaxSpacing = 0.09;   // between its points there: four make an arm of 0.35 m [m]
constexpr double kSurfaceMargin = 0.15;  // by which a surface may be nearer than the corner [m]
constexpr double kThrough = 0.3;         // a beam that goes on so far met no surface there [m]
constexpr double kHalfWidth = 0.12;      // of what a scan looks through, to both sides [m]
constexpr double kGrazing = 0.2;         // arms nearer than this to the line of sight hide [rad]

/// A feature as a scan sees it.
struct Sight {
  double distance = 0.0;
  double bearing = 0.0;   ///< In `laser`.
  double off_axis = 0.0;  ///< From the middle of where both arms are seen, in [0, pi].
};

Sight sight_of(const Feature& feature, const Pose2& T_map_laser) {
  const Point2 offset = feature.position - T_map_laser.translation();
  const double heading = std::atan2(offset.y(), offset.x());
  const double axis = feature.bisector + (feature.convex ? std::numbers::pi : 0.0);
  return {offset.norm(), wrap_angle(heading - T_map_laser.yaw),
          std::abs(wrap_angle(heading + std::numbers::pi - axis))};
}

/// The beam nearest to a bearing, or -1 for one outside the field of view.
std::ptrdiff_t beam_at(const LaserScan& scan, double bearing) {
  // The nearest turn of the bearing to the middle of the field of view.
  const double middle =
      scan.angle_min + 0.5 * static_cast<double>(scan.ranges.size()) * scan.angle_increment;
  const double unwrapped = middle + wrap_angle(bearing - middle);
  const auto beam = std::lround((unwrapped - scan.angle_min) / scan.angle_increment);
  return beam >= 0 && beam < static_cast<std::ptrdiff_t>(scan.ranges.size()) ? beam : -1;
}

/// Whether the beam goes as far as `distance`; one without a return does not count.
bool reaches(const LaserScan& scan, std::ptrdiff_t beam, double distance) {
  if (beam < 0 || !scan.has_return(static_cast<std::size_t>(beam))) return false;
  return static_cast<double>(scan.ranges[static_cast<std::size_t>(beam)]) >= distance;
}

bool looks_through(const LaserScan& scan, const Sight& sight) {
  const double half_width = std::atan2(kHalfWidth, sight.distance);
  const std::ptrdiff_t first = beam_at(scan, sight.bearing - half_width);
  const std::ptrdiff_t last = beam_at(scan, sight.bearing + half_width);
  if (first < 0 || last < 0) return false;
  for (std::ptrdiff_t beam = std::min(first, last); beam <= std::max(first, last); ++beam) {
    if (!reaches(scan, beam, sight.distance + kThrough)) return false;
  }
  return true;
}

/// Whether the scan would show the feature if it still stood there.
bool could_show(const LaserScan& scan, const Feature& feature, const Pose2& T_map_laser) {
  if (scan.ranges.empty()) return false;
  const Sight sight = sight_of(feature, T_map_laser);
  if (sight.distance > kMaxDistance ||
      sight.distance * std::abs(scan.angle_increment) > kMaxSpacing) {
    return false;
  }
  if (looks_through(scan, sight)) return true;
  const double half_opening = 0.5 * (std::numbers::pi - feature.turn_angle) - kGrazing;
  return sight.off_axis < half_opening &&
         reaches(scan, beam_at(scan, sight.bearing), sight.distance - kSurfaceMargin);
}

}  // namespace

FeatureHistory::FeatureHistory(FeatureMapParams params, int min_count)
    : params_(params), min_count_(min_count), drive_(params) {
  assert(min_count >= 1 && "min_count must be at least 1");
}

void FeatureHistory::begin_drive() {
  std::vector<Earlier> earlier;
  for (Feature& feature : standing()) earlier.push_back({std::move(feature), 0});
  earlier_ = std::move(earlier);
  drive_ = FeatureMap(params_);
}

void FeatureHistory::insert(std::span<const Feature> corners, const LaserScan& scan,
                            const Pose2& T_map_laser) {
  drive_.insert(corners);
  for (Earlier& earlier : earlier_) {
    if (earlier.looks < kLooksToForget && could_show(scan, earlier.feature, T_map_laser)) {
      ++earlier.looks;
    }
  }
}

std::vector<Feature> FeatureHistory::repeated() const {
  std::vector<Feature> features = standing();
  std::erase_if(features, [&](const Feature& feature) { return feature.count < min_count_; });
  return features;
}

std::vector<Feature> FeatureHistory::standing() const {
  std::vector<Feature> newer = drive_.features();
  std::vector<Feature> kept;
  std::vector<bool> dropped(newer.size(), false);
  for (const Earlier& earlier : earlier_) {
    const std::vector<std::size_t> near = drive_.neighbors(earlier.feature.position);
    const auto again = std::ranges::find_if(
        near, [&](std::size_t i) { return drive_.features()[i].count >= min_count_; });
    if (again != near.end()) {
      newer[*again].count += earlier.feature.count;
    } else if (!near.empty()) {
      // Shown, but not often enough to update its place.
      kept.push_back(earlier.feature);
      kept.back().count += drive_.features()[near.front()].count;
      for (const std::size_t i : near) dropped[i] = true;
    } else if (earlier.looks < kLooksToForget) {
      kept.push_back(earlier.feature);
    }
  }
  std::vector<Feature> standing;
  for (std::size_t i = 0; i < newer.size(); ++i) {
    if (!dropped[i]) standing.push_back(newer[i]);
  }
  std::ranges::move(kept, std::back_inserter(standing));
  return standing;
}

}  // namespace cornerfix

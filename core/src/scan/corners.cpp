#include <cornerfix/corners.hpp>

#include <array>
#include <cmath>
#include <utility>

#include "core/src/scan/line_intersection_corners.hpp"
#include "core/src/scan/vfp_corners.hpp"

namespace cornerfix {
namespace {

constexpr std::array<std::pair<CornerExtractor, std::string_view>, 2> kNames{{
    {CornerExtractor::kLineIntersection, "two_arm"},
    {CornerExtractor::kVfp, "vfp"},
}};

Feature feature_of(const Corner& corner) {
  return {.position = corner.position,
          .turn_angle = corner.turn_angle,
          .bisector = corner.bisector,
          .weight = corner.turn_angle,
          .convex = corner.convex,
          .sigma_m = std::sqrt(0.5 * corner.covariance.trace())};
}

}  // namespace

Feature transformed(const Pose2& T, Feature feature) {
  feature.position = T * feature.position;
  feature.bisector = wrap_angle(T.yaw + feature.bisector);
  return feature;
}

std::string_view to_string(CornerExtractor extractor) {
  for (const auto& [value, name] : kNames) {
    if (value == extractor) return name;
  }
  return "unknown";
}

std::optional<CornerExtractor> corner_extractor_from_string(std::string_view name) {
  for (const auto& [value, known] : kNames) {
    if (known == name) return value;
  }
  return std::nullopt;
}

std::vector<Feature> extract_corners(const LaserScan& scan, CornerExtractor extractor,
                                     double min_noise_m) {
  if (extractor == CornerExtractor::kVfp)
    return extract_vfp_corners(scan, vfp_params_for(scan.angle_increment));
  std::vector<Feature> features;
  for (const Corner& corner : extract_line_intersection_corners(scan, {.min_noise_m = min_noise_m}))
    features.push_back(feature_of(corner));
  return features;
}

}  // namespace cornerfix

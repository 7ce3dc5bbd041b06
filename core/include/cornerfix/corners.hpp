/// \file  Corners of scans as features, and how the corners of several scans are merged.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/pose2.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

/// A corner of the building. Frame: that of the map that holds it, or `laser` for a corner of one
/// scan.
struct Feature {
  Point2 position = Point2::Zero();  ///< [m]
  double turn_angle = 0.0;  ///< a of eq. (6) [rad]: 0 on a straight wall, pi/2 at a right angle.
  double bisector = 0.0;    ///< Heading of the bisector of the arms, into the smaller angle [rad].
  double weight = 0.0;      ///< Score that suppression compares: the largest a seen.
  int count = 1;            ///< Scans that showed it.
  bool convex = false;      ///< It juts out towards who sees it; the corner of a room does not.
  /// Standard deviation of the position in any direction, from the noise of the ranges alone [m]; 0
  /// where the extractor does not give it.
  double sigma_m = 0.0;
};

/// A feature of the source frame, in the target frame.
[[nodiscard]] Feature transformed(const Pose2& T, Feature feature);

/// How corners are found. Names on the wire: to_string(). Features of a map and of a submap match
/// best when one extractor found both.
enum class CornerExtractor {
  kLineIntersection,  ///< The intersection of two fitted lines.
  kVfp,               ///< The paper's vector feature points.
};

[[nodiscard]] std::string_view to_string(CornerExtractor extractor);
[[nodiscard]] std::optional<CornerExtractor> corner_extractor_from_string(std::string_view name);

/// Corners of one scan in `laser`, by ascending beam, with the extractor's default parameters for
/// this scanner. `scan` must pass validate(). O(beams).
/// \param min_noise_m  The ranges are at least as noisy as this, even if they look better;
/// kLineIntersection alone uses it.
[[nodiscard]] std::vector<Feature> extract_corners(const LaserScan& scan, CornerExtractor extractor,
                                                   double min_noise_m = 0.0);

/// How corners of several scans become the features of one map.
struct FeatureMapParams {
  double suppression_radius_m = 0.35;  ///< Corners nearer than this are one feature; > 0.
};

/// The first broken limit, or nothing.
[[nodiscard]] std::optional<Error> validate(const FeatureMapParams& params);

}  // namespace cornerfix

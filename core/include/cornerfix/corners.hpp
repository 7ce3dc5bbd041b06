/// \file  Corners as features: how they are found in scans and merged, and what each feature knows
/// of all others, its descriptor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
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

/// A descriptor holds the distance and the bearing of all other features, binned and sorted by
/// distance: Peng et al. 2023, section 3.1, eqs. (9)-(13), algorithm 2.
struct DescriptorParams {
  double distance_resolution_m = 0.2;  ///< d_res of eq. (13); > 0.
  double angle_resolution_rad =
      3.0 * 0.017453292519943295;  ///< a_res of eq. (12); must divide a turn.
  /// Pairs farther apart are left out, which bounds memory on large maps; > 0. The default holds
  /// most pairs of a submap; 5,000 features then take 2.3 MB at 0.02 and 23 MB at 0.2 features/m2.
  double max_distance_m = 30.0;
  friend bool operator==(const DescriptorParams&, const DescriptorParams&) = default;
};

/// nAngle of algorithm 3: bins in a full turn.
[[nodiscard]] int angle_bins(const DescriptorParams& params);

/// (d_im, a_im, m) of algorithm 2, in bins.
struct DescriptorEntry {
  std::uint16_t distance_bin = 0;
  std::uint16_t angle_bin = 0;  ///< In [0, angle_bins).
  std::uint32_t feature = 0;    ///< Index m of the other feature.
  friend bool operator==(const DescriptorEntry&, const DescriptorEntry&) = default;
};
static_assert(sizeof(DescriptorEntry) == 8);

/// The descriptors of a feature map, entries of one feature contiguous and ascending in
/// distance_bin.
struct DescriptorSet {
  DescriptorParams params;
  std::vector<std::uint32_t> offsets;  ///< size() + 1 begins into `entries`.
  std::vector<DescriptorEntry> entries;

  [[nodiscard]] std::size_t size() const { return offsets.empty() ? 0 : offsets.size() - 1; }
  [[nodiscard]] std::span<const DescriptorEntry> operator[](std::size_t feature) const {
    return std::span(entries).subspan(offsets[feature], offsets[feature + 1] - offsets[feature]);
  }
  [[nodiscard]] int angle_bins() const { return cornerfix::angle_bins(params); }
};

/// The first broken limit, or nothing.
[[nodiscard]] std::optional<Error> validate(const DescriptorParams& params);

/// Algorithm 2. `params` must pass validate(). Time and memory are proportional to the pairs of
/// features within max_distance_m, which is halved in the result until they are below 3e7.
[[nodiscard]] DescriptorSet describe(std::span<const Feature> features,
                                     const DescriptorParams& params);

/// The descriptor of one feature, its entries as in describe() but for the order of those in one
/// distance bin. O(features).
[[nodiscard]] std::vector<DescriptorEntry> describe_one(std::span<const Feature> features,
                                                        std::size_t feature,
                                                        const DescriptorParams& params);

}  // namespace cornerfix

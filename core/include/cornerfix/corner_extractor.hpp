/// \file  The corners of a scan as features, by the extractor of one's choice.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <cornerfix/feature_map.hpp>
#include <cornerfix/laser_scan.hpp>

namespace cornerfix {

/// How corners are found. Names on the wire: to_string(). Features of a map and of a submap match
/// best when one extractor found both.
enum class CornerExtractor {
  kTwoArm,  ///< Two fitted arms (two_arm_corners.hpp).
  kVfp,     ///< The paper's vector feature points (vfp_corners.hpp).
};

[[nodiscard]] std::string_view to_string(CornerExtractor extractor);
[[nodiscard]] std::optional<CornerExtractor> corner_extractor_from_string(std::string_view name);

/// Corners of one scan in `laser`, by ascending beam, with the extractor's default parameters for
/// this scanner. `scan` must pass validate(). O(beams).
/// \param min_noise_m  The ranges are at least as noisy as this, whatever they look like; kTwoArm
/// alone asks for it.
[[nodiscard]] std::vector<Feature> extract_corners(const LaserScan& scan, CornerExtractor extractor,
                                                   double min_noise_m = 0.0);

}  // namespace cornerfix

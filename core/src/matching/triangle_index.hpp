/// \file  Finds where a submap lies among any number of map features, by congruent triangles.
///
/// Three features of the submap and three of the map with the same sides give a transform. It is
/// tested feature by feature until it is clearly right or clearly chance (Wald 1945, the sequential
/// probability ratio test). It is a match when chance alone would not give as many hits (the number
/// of false alarms of Desolneux, Moisan, Morel 2000). Triangles are small and looked up by their
/// sides, so a town costs little more than a house.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>
#include <cornerfix/result.hpp>

#include "core/src/features/feature_map.hpp"

namespace cornerfix {

struct TriangleIndexParams {
  double min_side_m = 1.0;    ///< Shorter sides fix no heading; > 0.
  int neighbors = 18;         ///< Triangles reach as far as about so many features; in [3, 100].
  double tolerance_m = 0.15;  ///< Of a side's length and of a feature's place; > 0.
};

[[nodiscard]] std::optional<Error> validate(const TriangleIndexParams& params);

struct TriangleMatchParams {
  double overlap = 0.3;  ///< Share of the submap's features that the map holds; in (0, 1).
  double max_log_false_alarms = -7.0;  ///< Matches less surprising than this are chance; < 0.
  std::size_t max_trials = 200'000;    ///< Triangles and transforms tried; bounds the time; >= 1.
  std::size_t max_matches = 1;         ///< Distinct places after which the search ends; >= 1.
  std::uint64_t seed = 1;              ///< Same seed and input give the same answer.
};

[[nodiscard]] std::optional<Error> validate(const TriangleMatchParams& params);

struct TriangleMatch {
  Pose2 T_map_submap;             ///< Least squares over the inliers.
  int inliers = 0;                ///< Features of the submap that lie on one of the map.
  double log_false_alarms = 0.0;  ///< ln of how many matches as good chance alone would give.
  std::size_t trials = 0;         ///< How many had been made when it was found.
};

/// Of one map. Immutable and cheap to copy; any threads may share it.
class TriangleIndex {
 public:
  /// Of no features: matches nothing.
  TriangleIndex();

  /// Features must lie within 100 km of each other. For correct false alarms, no two may lie within
  /// the tolerance, as in a FeatureMap. The same holds for those of a submap. `params` must pass
  /// validate(). O(n * neighbors^2); 300 bytes a feature.
  TriangleIndex(std::span<const Feature> features_map, const TriangleIndexParams& params);

  /// The places where the submap fits far better than by chance, least false alarms first. None is
  /// an answer, not an error, and the only one for fewer than four features. At most `max_trials`
  /// trials of O(1), and O(m) for each transform that passes the sequential test; on average
  /// sub-linear in the features of the map. `params` must pass validate().
  [[nodiscard]] std::vector<TriangleMatch> match(std::span<const Feature> features_submap,
                                                 const TriangleMatchParams& params) const;

  [[nodiscard]] std::size_t triangle_count() const;
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  struct Data;
  class Search;
  std::shared_ptr<const Data> data_;
};

}  // namespace cornerfix

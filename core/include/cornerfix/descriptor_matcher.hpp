/// \file  Votes of one descriptor for another on the bearing difference; exhaustive (NMA) and
/// sampled (RMA) matching.
///
/// Peng et al. 2023, sections 3.2-3.4, eqs. (14), (15), (18), algorithm 3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <cornerfix/descriptor.hpp>

namespace cornerfix {

/// Pairs (m, n): feature indices, m in the submap (local), n in the map (global).
using FeaturePairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// The match of two descriptors: the fullest bucket of eq. (14).
struct DescriptorMatch {
  std::uint32_t local_feature = 0;   ///< i
  std::uint32_t global_feature = 0;  ///< j
  int angle_bin =
      0;          ///< a_max of eq. (14): local minus global bearing, in bins, in [0, angle_bins).
  int votes = 0;  ///< |match_ij|
};

/// p and N / N_local of eq. (18).
struct SampledMatchParams {
  double success_probability = 0.95;  ///< p; in (0, 1).
  double overlap = 0.5;               ///< N / N_local expected; in (0, 1].
  std::uint64_t seed = 1;             ///< Same seed and input give the same draws.
};

/// Algorithm 3 as published. Votes <= `min_votes` (S_t) give no pairs. Pairs come in the order of
/// the merge. Best case O(m + n), worst O((m + n) n).
[[nodiscard]] FeaturePairs match_descriptors(std::span<const DescriptorEntry> local,
                                             std::span<const DescriptorEntry> global,
                                             int angle_bins, int min_votes);

/// NMA, eq. (15): all local against all global descriptors; the `max_matches` best by votes, best
/// first, ties by ascending (global, local), at most one an angle bin and global feature. Those
/// with votes <= min_votes are left out.
[[nodiscard]] std::vector<DescriptorMatch> match_exhaustive(const DescriptorSet& local,
                                                            const DescriptorSet& global,
                                                            int min_votes, std::size_t max_matches);

/// RMA, eq. (18): `sample_count()` local descriptors drawn without replacement against all global
/// ones.
[[nodiscard]] std::vector<DescriptorMatch> match_sampled(const DescriptorSet& local,
                                                         const DescriptorSet& global, int min_votes,
                                                         std::size_t max_matches,
                                                         const SampledMatchParams& params);

/// k of eq. (18), at most `local_count`.
[[nodiscard]] std::size_t sample_count(const SampledMatchParams& params, std::size_t local_count);

/// The pairs behind a match, with (local_feature, global_feature) itself added in front.
[[nodiscard]] FeaturePairs pairs_of(const DescriptorMatch& match, const DescriptorSet& local,
                                    const DescriptorSet& global);

}  // namespace cornerfix

/// \file  Votes of one descriptor for another on the bearing difference; exhaustive (NMA) and
/// sampled (RMA) matching.
///
/// Peng et al. 2023, sections 3.2-3.4, eqs. (14), (15), (18), algorithm 3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <cornerfix/corners.hpp>
#include <cornerfix/localizer_params.hpp>
#include <cornerfix/result.hpp>

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
  friend bool operator==(const DescriptorMatch&, const DescriptorMatch&) = default;
};

/// The descriptors of a map, turned inside out for matching: for each distance bin, who has a
/// neighbour there and at which bearing. Two bytes an entry, in blocks of features whose vote
/// counters fit the first-level cache together. Immutable: any threads may share it.
class DescriptorIndex {
 public:
  DescriptorIndex() = default;

  /// O(entries). Keeps no reference to `descriptors`, which must come from describe().
  explicit DescriptorIndex(const DescriptorSet& descriptors);

  /// Descriptors in the index.
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const DescriptorParams& params() const { return params_; }
  [[nodiscard]] std::size_t angle_bins() const { return angle_bins_; }
  [[nodiscard]] std::size_t bytes() const {
    return offsets_.size() * sizeof(offsets_[0]) + slots_.size() * sizeof(slots_[0]);
  }

  [[nodiscard]] std::size_t block_size() const { return block_size_; }
  [[nodiscard]] std::size_t block_count() const { return block_count_; }
  /// Features of a block: all have block_size() but the last.
  [[nodiscard]] std::size_t block_size(std::size_t block) const;

  /// One slot an entry of the block's features in `distance_bin`. Slot + local angle bin is the
  /// counter of a vote: (feature within the block) * 2 * angle_bins + angle_bins + (local minus
  /// global angle bin).
  [[nodiscard]] std::span<const std::uint16_t> slots(std::size_t block,
                                                     std::size_t distance_bin) const;

 private:
  DescriptorParams params_;
  std::size_t size_ = 0;
  std::size_t angle_bins_ = 0;
  std::size_t distance_bins_ = 0;
  std::size_t block_size_ = 0;
  std::size_t block_count_ = 0;
  std::vector<std::uint32_t> offsets_;  ///< Begins into `slots_`, by block and distance bin.
  std::vector<std::uint16_t> slots_;
};

/// Algorithm 3 as published. Votes <= `min_votes` (S_t) give no pairs. Pairs come in the order of
/// the merge. Best case O(m + n), worst O((m + n) n).
[[nodiscard]] FeaturePairs match_descriptors(std::span<const DescriptorEntry> local,
                                             std::span<const DescriptorEntry> global,
                                             int angle_bins, int min_votes);

/// NMA, eq. (15): all local against all global descriptors; the `max_matches` best by votes, best
/// first, ties by ascending (global, local), at most one an angle bin and global feature. Of
/// equally full buckets of two descriptors the lowest angle bin is taken. Those with votes <=
/// min_votes are left out. Both sides must have been described with the same resolutions; a bucket
/// must not gather more than 65,535 votes.
[[nodiscard]] std::vector<DescriptorMatch> match_exhaustive(const DescriptorSet& local,
                                                            const DescriptorIndex& global,
                                                            int min_votes, std::size_t max_matches);

/// RMA, eq. (18): `sample_count()` local descriptors drawn without replacement against all global
/// ones.
[[nodiscard]] std::vector<DescriptorMatch> match_sampled(const DescriptorSet& local,
                                                         const DescriptorIndex& global,
                                                         int min_votes, std::size_t max_matches,
                                                         const SampledMatchParams& params);

/// The same for a map that is matched once: the index is made on the way.
[[nodiscard]] std::vector<DescriptorMatch> match_exhaustive(const DescriptorSet& local,
                                                            const DescriptorSet& global,
                                                            int min_votes, std::size_t max_matches);
[[nodiscard]] std::vector<DescriptorMatch> match_sampled(const DescriptorSet& local,
                                                         const DescriptorSet& global, int min_votes,
                                                         std::size_t max_matches,
                                                         const SampledMatchParams& params);

/// k of eq. (18), at most `local_count`.
[[nodiscard]] std::size_t sample_count(const SampledMatchParams& params, std::size_t local_count);

/// The pairs behind a match, with (local_feature, global_feature) itself added in front.
/// `local` and `global` are the descriptors of its two features.
[[nodiscard]] FeaturePairs pairs_of(const DescriptorMatch& match,
                                    std::span<const DescriptorEntry> local,
                                    std::span<const DescriptorEntry> global, int angle_bins);

}  // namespace cornerfix

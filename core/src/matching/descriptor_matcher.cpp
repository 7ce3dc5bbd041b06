#include "core/src/matching/descriptor_matcher.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <random>
#include <tuple>

#include "core/src/base/bounded_draw.hpp"

namespace cornerfix {
namespace {

/// Vote counters of a block: 16 kB, half a first-level cache.
constexpr std::size_t kCountersPerBlock = 8192;

/// The merge of algorithm 3: calls `vote(m, n, bucket)` for each pair of entries at equal distance.
template <typename Vote>
void merge(std::span<const DescriptorEntry> local, std::span<const DescriptorEntry> global,
           int angle_bins, Vote vote) {
  auto n = global.begin();
  for (const DescriptorEntry& m : local) {
    while (n != global.end() && n->distance_bin < m.distance_bin) ++n;
    for (auto tn = n; tn != global.end() && tn->distance_bin == m.distance_bin; ++tn) {
      const int difference = m.angle_bin - tn->angle_bin;
      vote(m, *tn, difference < 0 ? difference + angle_bins : difference);
    }
  }
}

/// Votes of one local descriptor for the features of one block, all at once.
class VoteCounters {
 public:
  explicit VoteCounters(const DescriptorIndex& index)
      : index_(index),
        angle_bins_(index.angle_bins()),
        counters_(index.block_size() * 2 * angle_bins_),
        folded_(angle_bins_) {}

  void count(std::span<const DescriptorEntry> local, std::size_t block) {
    std::ranges::fill(counters_, std::uint16_t{0});
    for (const DescriptorEntry& m : local) {
      std::uint16_t* const counters = counters_.data() + m.angle_bin;
      for (const std::uint16_t slot : index_.slots(block, m.distance_bin)) ++counters[slot];
    }
  }

  /// The fullest bucket of a feature of the block, eq. (14); the lowest of equal ones.
  [[nodiscard]] int most_votes(std::size_t feature_in_block) {
    const std::uint16_t* const below = counters_.data() + feature_in_block * 2 * angle_bins_;
    const std::uint16_t* const above = below + angle_bins_;
    std::uint16_t most = 0;
    for (std::size_t bin = 0; bin < angle_bins_; ++bin) {
      folded_[bin] = static_cast<std::uint16_t>(below[bin] + above[bin]);
      most = std::max(most, folded_[bin]);
    }
    return most;
  }

  /// The bucket that most_votes(), called last, has found.
  [[nodiscard]] int fullest_bin(int votes) const {
    return static_cast<int>(std::ranges::find(folded_, votes) - folded_.begin());
  }

 private:
  const DescriptorIndex& index_;
  std::size_t angle_bins_;
  std::vector<std::uint16_t> counters_;  ///< Differences from -angle_bins to angle_bins a feature.
  std::vector<std::uint16_t> folded_;    ///< The same, taken round the turn, of one feature.
};

/// The best matches so far. What cannot be among them is turned away by its votes alone.
class BestMatches {
 public:
  BestMatches(int min_votes, std::size_t max_matches)
      : max_matches_(max_matches), votes_to_beat_(min_votes) {}

  [[nodiscard]] int votes_to_beat() const { return votes_to_beat_; }

  void add(const DescriptorMatch& match) { added_.push_back(match); }

  /// To be called when all matches of the features seen so far have been added, and before those of
  /// any feature of a higher index. Therefore equal votes need not be compared again.
  void settle() {
    keep_one_a_bin_and_feature();
    best_.insert(best_.end(), added_.begin(), added_.end());
    added_.clear();
    std::ranges::sort(best_, {}, [](const DescriptorMatch& match) {
      return std::tuple(-match.votes, match.global_feature, match.local_feature);
    });
    if (best_.size() < max_matches_) return;
    best_.resize(max_matches_);
    if (!best_.empty()) votes_to_beat_ = std::max(votes_to_beat_, best_.back().votes);
  }

  [[nodiscard]] std::vector<DescriptorMatch> take() && { return std::move(best_); }

 private:
  void keep_one_a_bin_and_feature() {
    std::ranges::sort(added_, {}, [](const DescriptorMatch& match) {
      return std::tuple(match.global_feature, match.angle_bin, -match.votes, match.local_feature);
    });
    const auto is_repeated = [](const DescriptorMatch& a, const DescriptorMatch& b) {
      return a.global_feature == b.global_feature && a.angle_bin == b.angle_bin;
    };
    added_.erase(std::unique(added_.begin(), added_.end(), is_repeated), added_.end());
  }

  std::size_t max_matches_;
  int votes_to_beat_;
  std::vector<DescriptorMatch> added_;
  std::vector<DescriptorMatch> best_;
};

/// The given local descriptors against all global ones, block by block.
std::vector<DescriptorMatch> match_all(const DescriptorSet& local,
                                       std::span<const std::uint32_t> chosen,
                                       const DescriptorIndex& global, int min_votes,
                                       std::size_t max_matches) {
  if (global.size() == 0 || max_matches == 0) return {};
  assert(static_cast<std::size_t>(local.angle_bins()) == global.angle_bins() &&
         local.params.distance_resolution_m == global.params().distance_resolution_m &&
         "both sides must be described with the same resolutions");
  VoteCounters counters(global);
  BestMatches best(std::max(min_votes, 0), max_matches);
  for (std::size_t block = 0; block < global.block_count(); ++block) {
    for (const std::uint32_t i : chosen) {
      counters.count(local[i], block);
      for (std::size_t j = 0; j < global.block_size(block); ++j) {
        const int votes = counters.most_votes(j);
        if (votes <= best.votes_to_beat()) continue;
        const auto global_feature = static_cast<std::uint32_t>(block * global.block_size() + j);
        best.add({i, global_feature, counters.fullest_bin(votes), votes});
      }
    }
    best.settle();
  }
  return std::move(best).take();
}

std::vector<std::uint32_t> all_indices(std::size_t size) {
  std::vector<std::uint32_t> indices(size);
  std::iota(indices.begin(), indices.end(), 0U);
  return indices;
}

/// `count` different indices below `size`, by the beginning of a shuffle.
std::vector<std::uint32_t> draw_indices(std::size_t size, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::uint32_t> indices = all_indices(size);
  for (std::size_t i = 0; i < count; ++i) {
    std::swap(indices[i], indices[i + bounded_draw(random, size - i)]);
  }
  indices.resize(count);
  return indices;
}

}  // namespace

std::optional<Error> validate(const SampledMatchParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!(params.success_probability > 0.0 && params.success_probability < 1.0)) {
    return broken("success_probability", "must be in (0, 1)");
  }
  if (!(params.overlap > 0.0 && params.overlap <= 1.0)) {
    return broken("overlap", "must be in (0, 1]");
  }
  return std::nullopt;
}

DescriptorIndex::DescriptorIndex(const DescriptorSet& descriptors)
    : params_(descriptors.params),
      size_(descriptors.size()),
      angle_bins_(static_cast<std::size_t>(descriptors.angle_bins())),
      block_size_(std::max<std::size_t>(kCountersPerBlock / (2 * angle_bins_), 1)),
      block_count_((size_ + block_size_ - 1) / block_size_) {
  for (const DescriptorEntry& entry : descriptors.entries) {
    distance_bins_ = std::max<std::size_t>(distance_bins_, entry.distance_bin + 1U);
  }
  const auto list_of = [&](std::size_t feature, const DescriptorEntry& entry) {
    return feature / block_size_ * distance_bins_ + entry.distance_bin;
  };
  offsets_.assign(block_count_ * distance_bins_ + 1, 0);
  for (std::size_t feature = 0; feature < size_; ++feature) {
    for (const DescriptorEntry& entry : descriptors[feature]) ++offsets_[list_of(feature, entry)];
  }
  std::exclusive_scan(offsets_.begin(), offsets_.end(), offsets_.begin(), 0U);
  slots_.resize(descriptors.entries.size());
  std::vector<std::uint32_t> next = offsets_;
  for (std::size_t feature = 0; feature < size_; ++feature) {
    const std::size_t counters = feature % block_size_ * 2 * angle_bins_;
    for (const DescriptorEntry& entry : descriptors[feature]) {
      slots_[next[list_of(feature, entry)]++] =
          static_cast<std::uint16_t>(counters + angle_bins_ - entry.angle_bin);
    }
  }
}

std::size_t DescriptorIndex::block_size(std::size_t block) const {
  return std::min(block_size_, size_ - block * block_size_);
}

std::span<const std::uint16_t> DescriptorIndex::slots(std::size_t block,
                                                      std::size_t distance_bin) const {
  if (distance_bin >= distance_bins_) return {};
  const std::size_t list = block * distance_bins_ + distance_bin;
  return std::span(slots_).subspan(offsets_[list], offsets_[list + 1] - offsets_[list]);
}

FeaturePairs match_descriptors(std::span<const DescriptorEntry> local,
                               std::span<const DescriptorEntry> global, int angle_bins,
                               int min_votes) {
  std::vector<FeaturePairs> match_all(static_cast<std::size_t>(angle_bins));
  const FeaturePairs* fullest = &match_all.front();
  merge(local, global, angle_bins,
        [&](const DescriptorEntry& m, const DescriptorEntry& n, int bucket) {
          FeaturePairs& pairs = match_all[static_cast<std::size_t>(bucket)];
          pairs.emplace_back(m.feature, n.feature);
          if (pairs.size() > fullest->size()) fullest = &pairs;
        });
  return static_cast<int>(fullest->size()) > min_votes ? *fullest : FeaturePairs{};
}

std::vector<DescriptorMatch> match_exhaustive(const DescriptorSet& local,
                                              const DescriptorIndex& global, int min_votes,
                                              std::size_t max_matches) {
  return match_all(local, all_indices(local.size()), global, min_votes, max_matches);
}

std::vector<DescriptorMatch> match_exhaustive(const DescriptorSet& local,
                                              const DescriptorSet& global, int min_votes,
                                              std::size_t max_matches) {
  return match_exhaustive(local, DescriptorIndex(global), min_votes, max_matches);
}

std::vector<DescriptorMatch> match_sampled(const DescriptorSet& local,
                                           const DescriptorIndex& global, int min_votes,
                                           std::size_t max_matches,
                                           const SampledMatchParams& params) {
  const std::size_t count = sample_count(params, local.size());
  return match_all(local, draw_indices(local.size(), count, params.seed), global, min_votes,
                   max_matches);
}

std::vector<DescriptorMatch> match_sampled(const DescriptorSet& local, const DescriptorSet& global,
                                           int min_votes, std::size_t max_matches,
                                           const SampledMatchParams& params) {
  return match_sampled(local, DescriptorIndex(global), min_votes, max_matches, params);
}

std::size_t sample_count(const SampledMatchParams& params, std::size_t local_count) {
  assert(!validate(params) && "params must pass validate()");
  // Eq. (18). At full overlap the logarithm is -infinity and one draw is enough.
  const double draws = std::log(1.0 - params.success_probability) / std::log(1.0 - params.overlap);
  const double at_least_one = std::max(std::ceil(draws), 1.0);
  return static_cast<std::size_t>(std::min(at_least_one, static_cast<double>(local_count)));
}

FeaturePairs pairs_of(const DescriptorMatch& match, std::span<const DescriptorEntry> local,
                      std::span<const DescriptorEntry> global, int angle_bins) {
  FeaturePairs pairs{{match.local_feature, match.global_feature}};
  merge(local, global, angle_bins,
        [&](const DescriptorEntry& m, const DescriptorEntry& n, int bucket) {
          if (bucket == match.angle_bin) pairs.emplace_back(m.feature, n.feature);
        });
  return pairs;
}

}  // namespace cornerfix

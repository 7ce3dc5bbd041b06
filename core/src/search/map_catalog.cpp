#include <cornerfix/map_source.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/src/base/in_parallel.hpp"
#include "core/src/search/corner_pairs.hpp"
#include "core/src/search/hit_judge.hpp"

namespace cornerfix {
namespace {

constexpr std::size_t kMaxNeighbors = 12;     // of a corner of a map, to make pairs with
constexpr std::size_t kMaxQueryCorners = 16;  // those seen most often
constexpr std::size_t kMaxMatches = 400'000;  // of pairs, the rarest first; bounds the time
constexpr std::size_t kMaxSingleCorners = 8;  // seen, each compared with all of the maps
constexpr double kMaxTurnDifference = 0.35;   // between two views of one corner [rad]
constexpr double kKeptMean = -0.3;  // mean weight of all hits of a pose that ranks a map [nat]
constexpr std::size_t kMinForCompaction = 64;

}  // namespace

/// The matches of one question.
class MapCatalog::Ranking {
 public:
  Ranking(const MapCatalog& catalog, const MapQuery& query)
      : catalog_(catalog),
        judge_(query.hits),
        seen_(query.corners.begin(), query.corners.end()),
        best_(catalog.all_.size()) {
    std::ranges::stable_sort(seen_, std::ranges::greater{}, &Feature::count);
    if (seen_.size() > kMaxQueryCorners) seen_.resize(kMaxQueryCorners);
  }

  std::vector<RankedMap> run() {
    if (judge_.empty()) return {};
    judge_pairs();
    judge_corners();
    std::vector<RankedMap> ranked;
    for (std::size_t slot = 0; slot < best_.size(); ++slot) {
      if (best_[slot]) ranked.push_back(refined(catalog_.all_[slot], *best_[slot]));
    }
    std::ranges::sort(ranked, [](const RankedMap& a, const RankedMap& b) {
      return std::pair(-a.mean_weight, a.key) < std::pair(-b.mean_weight, b.key);
    });
    return ranked;
  }

 private:
  /// Pairs of maps that may be one pair seen.
  struct List {
    const std::vector<Posting>* postings = nullptr;
    Pose2 T_pair_base_link;
  };
  struct Best {
    double mean = 0.0;
    Pose2 T_grid_base_link;
  };

  [[nodiscard]] std::vector<List> lists_of_pairs() const {
    std::vector<List> lists;
    std::vector<std::size_t> keys;
    for (const Feature& first : seen_) {
      for (const Feature& second : seen_) {
        if (&first == &second) continue;
        const auto pair = corner_pair({first.position, first.bisector, first.convex},
                                      {second.position, second.bisector, second.convex});
        if (!pair) continue;
        keys.clear();
        keys_near(*pair, keys);
        for (const std::size_t key : keys) {
          const std::vector<Posting>& postings = catalog_.postings_[key];
          if (!postings.empty()) lists.push_back({&postings, inverse(pair->T_frame_pair)});
        }
      }
    }
    std::ranges::stable_sort(lists, {}, [](const List& list) { return list.postings->size(); });
    return lists;
  }

  void judge_pairs() {
    for (const List& list : lists_of_pairs()) {
      matches_ += list.postings->size();
      if (matches_ > kMaxMatches) return;
      for (const Posting& posting : *list.postings) {
        const Pose2 T_grid_pair{static_cast<double>(posting.x), static_cast<double>(posting.y),
                                static_cast<double>(posting.yaw)};
        judge(posting.slot, T_grid_pair * list.T_pair_base_link);
      }
    }
  }

  /// A single corner gives a pose, too: with few maps there is time for all of them.
  void judge_corners() {
    for (std::size_t i = 0; i < std::min(kMaxSingleCorners, seen_.size()); ++i) {
      matches_ += catalog_.corners_;
      if (matches_ > kMaxMatches) return;
      const Feature& seen = seen_[i];
      const Pose2 T_corner_base_link =
          inverse(Pose2{seen.position.x(), seen.position.y(), seen.bisector});
      for (const auto& [key, slot] : catalog_.slots_) {
        for (const SketchCorner& corner : catalog_.all_[slot].sketch.corners) {
          const bool may_be_same =
              corner.convex == seen.convex && std::abs(static_cast<double>(corner.turn_angle) -
                                                       seen.turn_angle) < kMaxTurnDifference;
          if (!may_be_same) continue;
          judge(slot, Pose2{static_cast<double>(corner.x), static_cast<double>(corner.y),
                            static_cast<double>(corner.bisector)} *
                          T_corner_base_link);
        }
      }
    }
  }

  void judge(std::uint32_t at, const Pose2& T_grid_base_link) {
    const Slot& slot = catalog_.all_[at];
    if (!slot.is_current) return;
    const auto mean = judge_.mean_at(slot.sketch, T_grid_base_link);
    if (!mean || *mean < kKeptMean) return;
    std::optional<Best>& best = best_[at];
    if (!best || *mean > best->mean) best = Best{*mean, T_grid_base_link};
  }

  [[nodiscard]] RankedMap refined(const Slot& slot, const Best& best) const {
    const auto [mean, pose] = judge_.refined(slot.sketch, best.mean, best.T_grid_base_link);
    return {slot.key, mean, slot.sketch.T_map_grid * pose};
  }

  const MapCatalog& catalog_;
  HitJudge judge_;
  std::vector<Feature> seen_;  ///< Those seen most often first.
  std::size_t matches_ = 0;
  std::vector<std::optional<Best>> best_;  ///< By slot.
};

void MapCatalog::put(MapKey key, MapSketch sketch) {
  compact_if_due();
  index(pairs_of(add(key, std::move(sketch))));
}

void MapCatalog::put_all(std::vector<std::pair<MapKey, MapSketch>> maps) {
  constexpr std::size_t kMapsAtATime = 256;  // bounds what is kept besides
  std::vector<std::vector<std::pair<std::uint32_t, Posting>>> pairs;
  for (std::size_t begin = 0; begin < maps.size(); begin += kMapsAtATime) {
    compact_if_due();
    std::vector<std::uint32_t> slots;
    for (std::size_t i = begin; i < std::min(begin + kMapsAtATime, maps.size()); ++i)
      slots.push_back(add(maps[i].first, std::move(maps[i].second)));
    pairs.assign(slots.size(), {});
    for_each_in_parallel(slots.size(), [&](std::size_t i) { pairs[i] = pairs_of(slots[i]); });
    for (const auto& pairs_of_map : pairs) index(pairs_of_map);
  }
}

std::uint32_t MapCatalog::add(MapKey key, MapSketch sketch) {
  erase(key);
  const auto slot = static_cast<std::uint32_t>(all_.size());
  free_area_m2_ += sketch.free_area_m2;
  corners_ += sketch.corners.size();
  all_.push_back({key, true, std::move(sketch)});
  slots_.emplace(key, slot);
  return slot;
}

void MapCatalog::erase(MapKey key) {
  const auto found = slots_.find(key);
  if (found == slots_.end()) return;
  Slot& slot = all_[found->second];
  free_area_m2_ -= slot.sketch.free_area_m2;
  corners_ -= slot.sketch.corners.size();
  slot.is_current = false;
  slot.sketch = {};
  slots_.erase(found);
}

void MapCatalog::compact_if_due() {
  if (all_.size() < kMinForCompaction || all_.size() <= 2 * slots_.size()) return;
  std::vector<Slot> before = std::exchange(all_, {});
  slots_.clear();
  for (std::vector<Posting>& list : postings_) list.clear();
  free_area_m2_ = 0.0;
  corners_ = 0;
  for (Slot& slot : before) {
    if (slot.is_current) put(slot.key, std::move(slot.sketch));
  }
}

/// A corner makes pairs with those nearest to it. Each pair is kept once.
std::vector<std::pair<std::uint32_t, MapCatalog::Posting>> MapCatalog::pairs_of(
    std::uint32_t slot) const {
  const std::vector<SketchCorner>& corners = all_[slot].sketch.corners;
  const auto oriented = [](const SketchCorner& corner) {
    return OrientedCorner{{static_cast<double>(corner.x), static_cast<double>(corner.y)},
                          static_cast<double>(corner.bisector),
                          corner.convex};
  };
  const auto neighbors = neighboring_pairs(corners, kMaxNeighbors);
  std::vector<std::pair<std::uint32_t, Posting>> pairs;
  pairs.reserve(neighbors.size());
  for (const auto& [i, j] : neighbors) {
    const auto pair = corner_pair(oriented(corners[i]), oriented(corners[j]));
    if (!pair) continue;
    const Pose2& frame = pair->T_frame_pair;
    pairs.emplace_back(static_cast<std::uint32_t>(key_of(*pair)),
                       Posting{slot, static_cast<float>(frame.x), static_cast<float>(frame.y),
                               static_cast<float>(frame.yaw)});
  }
  return pairs;
}

void MapCatalog::index(std::span<const std::pair<std::uint32_t, Posting>> pairs) {
  if (postings_.empty()) postings_.resize(kPairKeys);
  for (const auto& [key, posting] : pairs) postings_[key].push_back(posting);
}

std::size_t MapCatalog::bytes() const {
  std::size_t bytes = sizeof(MapCatalog) + postings_.capacity() * sizeof(postings_[0]);
  for (const std::vector<Posting>& list : postings_) bytes += list.capacity() * sizeof(Posting);
  for (const Slot& slot : all_) bytes += sizeof(Slot) + slot.sketch.bytes();
  constexpr std::size_t kTreeNode = 64;
  return bytes + slots_.size() * kTreeNode;
}

std::vector<RankedMap> MapCatalog::rank(const MapQuery& query) const {
  if (all_.empty()) return {};
  return Ranking(*this, query).run();
}

}  // namespace cornerfix

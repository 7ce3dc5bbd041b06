/// \file  Maps that are too many to hold: where a localizer gets them from, and a catalog that
/// ranks thousands of them by what a robot saw, without loading any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <cornerfix/localization_map.hpp>
#include <cornerfix/map_sketch.hpp>

namespace cornerfix {

/// Names a map in a catalog; chosen by the caller.
using MapKey = std::int64_t;

/// What a robot saw, in base_link at its last scan.
struct MapQuery {
  std::span<const Feature> corners;
  std::span<const Point2> hits;
};

struct RankedMap {
  MapKey key = 0;
  double mean_weight = 0.0;  ///< Of the hits at the best pose, optimistic [nat].
  Pose2 T_map_base_link;     ///< The best pose, to about 0.2 m and 2 deg.
};

/// Copies of sketches with an inverted file over pairs of corners. The distance of two corners and
/// the directions of their bisectors do not depend on the pose of the robot. So pairs seen are
/// looked up among the pairs of all maps. Each match gives a pose in one map. The pose is judged by
/// the hits in the sketch of that map, and a map is ranked by its best pose. Among few maps, single
/// corners give poses too. Not synchronised.
class MapCatalog {
 public:
  /// Adds a map, or replaces what is known of it. Amortised O(corners).
  void put(MapKey key, MapSketch sketch);
  /// As put() of one after the other, but the work is done on all cores.
  void put_all(std::vector<std::pair<MapKey, MapSketch>> maps);
  /// Without effect when it is not there.
  void erase(MapKey key);

  [[nodiscard]] bool contains(MapKey key) const { return slots_.contains(key); }
  [[nodiscard]] std::size_t size() const { return slots_.size(); }
  /// Known-free space of all maps.
  [[nodiscard]] double free_area_m2() const { return free_area_m2_; }
  /// In memory.
  [[nodiscard]] std::size_t bytes() const;

  /// Maps with a pose at which corners and the hits fit, best first; of equals the lowest key. A
  /// map that is left out has no such pose among those that corners seen propose: from pairs, and
  /// from single corners where the maps have few enough. O(matches + maps), 400,000 matches at
  /// most.
  [[nodiscard]] std::vector<RankedMap> rank(const MapQuery& query) const;

 private:
  /// A pair of corners: its frame has its origin at the first one and x towards the second one.
  struct Posting {
    std::uint32_t slot = 0;
    float x = 0.0F;  ///< In `grid` of the sketch [m].
    float y = 0.0F;
    float yaw = 0.0F;
  };
  struct Slot {
    MapKey key = 0;
    bool is_current = true;  ///< Not replaced and not erased.
    MapSketch sketch;
  };

  class Ranking;

  /// Appends a slot that is not indexed yet.
  std::uint32_t add(MapKey key, MapSketch sketch);
  /// The pairs of corners of a map with their keys.
  [[nodiscard]] std::vector<std::pair<std::uint32_t, Posting>> pairs_of(std::uint32_t slot) const;
  void index(std::span<const std::pair<std::uint32_t, Posting>> pairs);
  /// Forgets what was replaced or erased, once that is more than the rest.
  void compact_if_due();

  std::vector<Slot> all_;
  std::map<MapKey, std::uint32_t> slots_;       ///< Of current maps, into all_.
  std::vector<std::vector<Posting>> postings_;  ///< By the key of the pair.
  double free_area_m2_ = 0.0;
  std::size_t corners_ = 0;  ///< Of current maps.
};

/// All maps that a robot may be in. A localizer ranks them by what the robot saw and loads those
/// that may be the right one. It is called by the thread that calls the localizer.
class MapSource {
 public:
  virtual ~MapSource() = default;

  /// How many maps there are.
  [[nodiscard]] virtual std::size_t size() = 0;
  /// Known-free space of all of them.
  [[nodiscard]] virtual double free_area_m2() = 0;
  /// As MapCatalog::rank().
  [[nodiscard]] virtual std::vector<RankedMap> rank(const MapQuery& query) = 0;
  /// All keys, ascending.
  [[nodiscard]] virtual std::vector<MapKey> keys() = 0;
  /// The map with this name; nothing when there is none.
  [[nodiscard]] virtual std::optional<MapKey> find(std::string_view name) = 0;
  /// Null when the map cannot be loaded, or has no room in memory beside the `held_bytes` of the
  /// maps that the localizer keeps. It then counts as a rival that was not searched.
  [[nodiscard]] virtual LocalizationMapPtr load(MapKey key, std::size_t held_bytes) = 0;
};

}  // namespace cornerfix

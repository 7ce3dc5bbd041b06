/// \file  All maps of the database, ranked by their sketches: for robots that may be in any map.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <cornerfix/map_source.hpp>
#include <cornerfix/result.hpp>

#include "server/map_library.hpp"
#include "server/store_access.hpp"

namespace cornerfix::server {

struct MapRankingSettings {
  /// For how long a map must be unchanged before its sketch is made: a growing map changes with
  /// every batch.
  std::chrono::steady_clock::duration quiet_time = std::chrono::seconds(10);
  std::function<std::chrono::steady_clock::time_point()> now = std::chrono::steady_clock::now;
  /// Looks for changes twice a second and makes sketches, in a thread of low priority.
  bool has_thread = true;
};

struct MapRankingUse {
  std::size_t maps = 0;      ///< With content.
  std::size_t sketches = 0;  ///< Of them, those with a current sketch.
  std::size_t bytes = 0;     ///< Of the catalog.
};

/// Holds the sketch of every map and no map. A map without a current sketch may be the right one by
/// any ranking: it ranks as high as the best. Keys are the ids of maps. Any threads may call.
class MapRanking {
 public:
  /// What is known of a map with content.
  struct Entry {
    std::string name;
    std::uint64_t revision = 0;
    friend bool operator==(const Entry&, const Entry&) = default;
  };
  /// What MapLibrary::load() needs.
  [[nodiscard]] static storage::MapInfo info_of(MapKey key, const Entry& entry);

  MapRanking(std::shared_ptr<StoreAccess> stores, std::shared_ptr<MapLibrary> library,
             MapRankingSettings settings = {});
  ~MapRanking();
  MapRanking(const MapRanking&) = delete;
  MapRanking& operator=(const MapRanking&) = delete;

  /// Learns of what changed in the database, here or elsewhere. Cheap when nothing did, else O(maps
  /// + changes).
  [[nodiscard]] Result<void> refresh();
  /// Makes and stores the sketch of one map that has none and has been quiet. Returns whether there
  /// was one.
  bool make_next_sketch();

  /// Grows with every change that refresh() learns of.
  [[nodiscard]] std::uint64_t version() const;
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] double free_area_m2() const;
  [[nodiscard]] MapRankingUse use() const;
  /// As MapSource::rank().
  [[nodiscard]] std::vector<RankedMap> rank(const MapQuery& query) const;
  [[nodiscard]] std::vector<MapKey> keys() const;
  [[nodiscard]] std::optional<MapKey> find(std::string_view name) const;
  /// Nothing when the map is gone or has no content.
  [[nodiscard]] std::optional<Entry> entry(MapKey key) const;

 private:
  using Time = std::chrono::steady_clock::time_point;

  /// A map without a current sketch.
  struct Missing {
    Time changed_at{};
    bool has_failed = false;
  };

  [[nodiscard]] std::shared_lock<std::shared_mutex> reading() const;
  [[nodiscard]] std::unique_lock<std::shared_mutex> writing();
  [[nodiscard]] Result<void> read_changes();
  [[nodiscard]] Result<std::vector<storage::StoredSketch>> read_sketches(
      const std::vector<MapKey>& wanted);
  void take(std::vector<storage::SketchState> states, std::vector<storage::StoredSketch> sketches);
  void work();

  std::shared_ptr<StoreAccess> stores_;
  std::shared_ptr<MapLibrary> library_;
  MapRankingSettings settings_;

  std::mutex refresh_mutex_;
  std::optional<std::uint64_t> epoch_;  ///< Of the store at the last refresh().

  /// Who writes holds it while waiting, so that no more readers come first.
  mutable std::mutex gate_;
  mutable std::shared_mutex mutex_;  ///< Of what follows; only refresh_mutex_ is held around it.
  MapCatalog catalog_;
  std::map<MapKey, Entry> entries_;
  std::map<MapKey, std::uint64_t> sketched_;  ///< Revision of the sketch in the catalog.
  std::map<MapKey, Missing> missing_;
  std::uint64_t version_ = 0;

  std::mutex worker_mutex_;
  std::condition_variable closing_changed_;
  bool is_closing_ = false;
  std::thread worker_;
};

}  // namespace cornerfix::server

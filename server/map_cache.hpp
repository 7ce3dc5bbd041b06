/// \file  Maps that are ready to localize in, kept for the next asker.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include <cornerfix/localization_map.hpp>

namespace cornerfix::server {

struct MapCacheUse {
  std::size_t maps = 0;     ///< In memory, those in use included.
  std::size_t bytes = 0;    ///< Of them.
  std::uint64_t loads = 0;  ///< Maps made ready since the start.
};

/// All maps in memory. Those that nobody else holds are released when there is no room, the ones
/// not asked for longest first. Any threads may call.
class MapCache {
 public:
  using Key = std::pair<std::int64_t, std::uint64_t>;  ///< Map id and revision.

  explicit MapCache(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Null when it is not there.
  [[nodiscard]] LocalizationMapPtr find(const Key& key);
  /// In place of other revisions of the map that nobody holds. The newest stays, however large.
  void keep(const Key& key, const LocalizationMapPtr& map);
  /// Releases what nobody else holds until a tenth of the room is free, if there is none. Returns
  /// whether the maps have room.
  bool make_room();
  [[nodiscard]] MapCacheUse use();
  /// What the map needed when it was last kept; 0 when that is not known.
  [[nodiscard]] std::size_t known_bytes(const Key& key);

 private:
  struct Entry {
    Key key;
    LocalizationMapPtr map;
    std::size_t bytes = 0;
  };

  std::size_t max_bytes_;
  std::mutex mutex_;
  /// With the mutex held; the first entry stays.
  bool release_down_to(std::size_t bytes);

  std::list<Entry> entries_;                                             ///< Last used first.
  std::size_t bytes_ = 0;                                                ///< Of all entries.
  std::map<std::int64_t, std::pair<std::uint64_t, std::size_t>> sizes_;  ///< Revision and bytes.
  std::uint64_t loads_ = 0;
};

}  // namespace cornerfix::server

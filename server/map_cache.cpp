#include "server/map_cache.hpp"

#include <algorithm>
#include <iterator>

namespace cornerfix::server {

LocalizationMapPtr MapCache::find(const Key& key) {
  const std::lock_guard lock(mutex_);
  if (const auto found = std::ranges::find(entries_, key, &Entry::key); found != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, found);
    return entries_.front().map;
  }
  const auto known = known_.find(key);
  return known == known_.end() ? nullptr : known->second.lock();
}

void MapCache::keep(const Key& key, const LocalizationMapPtr& map) {
  const std::lock_guard lock(mutex_);
  entries_.remove_if([&](const Entry& old) { return old.key.first == key.first; });
  entries_.push_front({key, map, map->bytes()});
  sizes_[key.first] = {key.second, entries_.front().bytes};
  ++loads_;
  std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
  known_.insert_or_assign(key, map);
  std::size_t bytes = 0;
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    bytes += entry->bytes;
    const bool is_first = entry == entries_.begin();
    entry = bytes > max_bytes_ && !is_first ? entries_.erase(entry) : std::next(entry);
  }
}

MapCacheUse MapCache::use() {
  const std::lock_guard lock(mutex_);
  MapCacheUse use{.maps = entries_.size(), .loads = loads_};
  for (const Entry& entry : entries_) use.bytes += entry.bytes;
  return use;
}

std::size_t MapCache::known_bytes(const Key& key) {
  const std::lock_guard lock(mutex_);
  const auto found = sizes_.find(key.first);
  return found != sizes_.end() && found->second.first == key.second ? found->second.second : 0;
}

}  // namespace cornerfix::server

#include "server/map_cache.hpp"

#include <algorithm>
#include <tuple>

namespace cornerfix::server {

LocalizationMapPtr MapCache::find(const Key& key) {
  const std::lock_guard lock(mutex_);
  if (const auto found = std::ranges::find(entries_, key, &Entry::key); found != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, found);
    return entries_.front().map;
  }
  return nullptr;
}

void MapCache::keep(const Key& key, const LocalizationMapPtr& map) {
  const std::lock_guard lock(mutex_);
  // A pointer of the cache's alone cannot be copied by anybody else while the mutex is held.
  std::erase_if(entries_, [&](const Entry& old) {
    const bool is_outdated = old.key.first == key.first && old.map.use_count() == 1;
    if (is_outdated) bytes_ -= old.bytes;
    return is_outdated;
  });
  entries_.push_front({key, map, map->bytes()});
  bytes_ += entries_.front().bytes;
  sizes_[key.first] = {key.second, entries_.front().bytes};
  ++loads_;
  std::ignore = release_down_to(max_bytes_);
}

bool MapCache::make_room() {
  const std::lock_guard lock(mutex_);
  return bytes_ <= max_bytes_ || release_down_to(max_bytes_ - max_bytes_ / 10);
}

bool MapCache::release_down_to(std::size_t bytes) {
  for (auto entry = entries_.end(); bytes_ > bytes && entry != entries_.begin();) {
    --entry;
    if (entry->map.use_count() > 1 || entry == entries_.begin()) continue;
    bytes_ -= entry->bytes;
    entry = entries_.erase(entry);
  }
  return bytes_ <= bytes || entries_.size() <= 1;
}

MapCacheUse MapCache::use() {
  const std::lock_guard lock(mutex_);
  return {.maps = entries_.size(), .bytes = bytes_, .loads = loads_};
}

std::size_t MapCache::known_bytes(const Key& key) {
  const std::lock_guard lock(mutex_);
  const auto found = sizes_.find(key.first);
  return found != sizes_.end() && found->second.first == key.second ? found->second.second : 0;
}

}  // namespace cornerfix::server

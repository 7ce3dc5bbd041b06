#include "server/ranked_map_source.hpp"

#include <spdlog/spdlog.h>

#include <utility>

namespace cornerfix::server {

RankedMapSource::RankedMapSource(std::shared_ptr<MapRanking> ranking,
                                 std::shared_ptr<MapLibrary> library, std::size_t max_bytes)
    : ranking_(std::move(ranking)), library_(std::move(library)), max_bytes_(max_bytes) {}

LocalizationMapPtr RankedMapSource::load(MapKey key, std::size_t held_bytes) {
  const auto entry = ranking_->entry(key);
  if (!entry) return nullptr;
  const storage::MapInfo info = MapRanking::info_of(key, *entry);
  const auto fits = [&](std::size_t bytes) {
    return held_bytes == 0 || held_bytes + bytes <= max_bytes_;
  };
  if (!fits(library_->known_bytes(info))) return nullptr;
  auto map = library_->load(info);
  if (!map) {
    spdlog::warn("map {} is left out of a search of every map: {}", entry->name,
                 map.error().message);
    return nullptr;
  }
  return fits((*map)->bytes()) ? std::move(*map) : nullptr;
}

}  // namespace cornerfix::server

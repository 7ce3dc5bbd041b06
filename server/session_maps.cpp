#include "server/session_maps.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace cornerfix::server {

using storage::MapInfo;

namespace {

/// Whether a map could not be loaded for what it is, not because of something that may pass.
bool is_of_the_map(const Error& error) {
  return error.code == ErrorCode::kConflict || error.code == ErrorCode::kCorruptData ||
         error.code == ErrorCode::kNotFound;
}

Error too_large(std::size_t maps, std::size_t max_bytes) {
  return {ErrorCode::kConflict,
          "the session's " + std::to_string(maps) + " maps need more than " +
              std::to_string(max_bytes) +
              " bytes to be searched together (max_searched_map_bytes): name fewer maps",
          ""};
}

/// A map of one free cell; without any for no area.
LocalizationMapPtr stand_in(double free_area_m2) {
  MapContent content;
  if (free_area_m2 > 0.0) {
    content.grid.resolution = std::sqrt(free_area_m2);
    content.grid.width = content.grid.height = 1;
    content.grid.cells = {Cell::kFree};
  }
  return std::make_shared<const LocalizationMap>("", 0, std::move(content));
}

}  // namespace

Result<SessionMaps> load_all(MapLibrary& library, std::span<const MapInfo> infos,
                             std::size_t max_bytes, bool is_named) {
  const auto fits = [&](std::size_t bytes) { return infos.size() <= 1 || bytes <= max_bytes; };
  std::size_t known_bytes = 0;
  for (const MapInfo& info : infos) known_bytes += library.known_bytes(info);
  if (!fits(known_bytes)) return too_large(infos.size(), max_bytes);
  SessionMaps loaded{.maps = {}, .ids = {}, .holds_all = true};
  std::size_t bytes = 0;
  for (const MapInfo& info : infos) {
    if (!info.bounds) continue;  // Nothing in it yet.
    auto map = library.load(info);
    if (!map && !is_named && is_of_the_map(map.error())) {
      spdlog::warn("map {} is left out of a search of every map: {}", info.name,
                   map.error().message);
      continue;
    }
    if (!map) return map.error();
    bytes += (*map)->bytes();
    if (!fits(bytes)) return too_large(infos.size(), max_bytes);
    loaded.free_area_m2 += (*map)->free_area_m2();
    loaded.maps.push_back(std::move(*map));
    loaded.ids.push_back(info.id);
  }
  return loaded;
}

Result<SessionMaps> load_one(MapLibrary& library, std::span<const MapInfo> infos, std::int64_t id,
                             double free_area_m2) {
  static const LocalizationMapPtr nothing = stand_in(0.0);
  SessionMaps loaded{.maps = {}, .ids = {}, .holds_all = false, .free_area_m2 = free_area_m2};
  double other_area_m2 = free_area_m2;
  for (const MapInfo& info : infos) {
    if (!info.bounds) continue;
    LocalizationMapPtr map = nothing;
    if (info.id == id) {
      auto real = library.load(info);
      if (!real) return real.error();
      map = std::move(*real);
      other_area_m2 -= map->free_area_m2();
    }
    loaded.maps.push_back(std::move(map));
    loaded.ids.push_back(info.id);
  }
  const auto other = std::ranges::find(loaded.maps, nothing);
  if (other != loaded.maps.end() && other_area_m2 > 0.0) *other = stand_in(other_area_m2);
  return loaded;
}

}  // namespace cornerfix::server

/// \file  Where a localizer gets maps from when there are too many to hold all of them.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include <cornerfix/localization_map.hpp>
#include <cornerfix/map_catalog.hpp>

namespace cornerfix {

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

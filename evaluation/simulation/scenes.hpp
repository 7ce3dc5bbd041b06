/// \file  Generated occupancy maps of kinds of places that recorded runs lack.
///
/// A layout seed draws what lasts: size, angle, wall thickness, racks, rooms, trees. A change seed
/// draws what does not last: stock, parked cars, furniture, which doors stand open. To test a map
/// of a place that has changed since, map with one change seed and localize with another.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>

namespace cornerfix::evaluation {

enum class SceneKind : std::uint8_t {
  kWarehouse,  ///< Pallet racks, columns, dock doors; the stock changes.
  kYard,       ///< Outdoors: buildings, trees, poles, fences; the parked cars change.
  kCorridors,  ///< Long parallel corridors of equal doors; which doors are open changes.
  kOffice,     ///< A ring corridor about a core, lined with equal rooms; chairs and doors change.
  kHome,       ///< Small rooms; the loose furniture changes.
  kHall,       ///< A large hall with a grid of columns; tables and stands change.
  kGlass,  ///< Glazed rooms: beams pass the panes, robots do not; which blinds are down changes.
};

/// warehouse, yard, corridors, office, home, hall or glass; nothing for any other name.
[[nodiscard]] std::optional<SceneKind> scene_kind_from_string(std::string_view name);
[[nodiscard]] std::string_view to_string(SceneKind kind);
[[nodiscard]] const std::vector<SceneKind>& all_scene_kinds();
[[nodiscard]] std::vector<std::string> scene_kind_names();

/// The occupancy map of one place, 0.05 m per cell. Same kind and seeds, same map. Two change seeds
/// of one layout seed give maps in one frame. Free space is connected. Cells that beams pass and
/// robots do not (glass, the outside of buildings) are unknown. Up to 15 million cells.
[[nodiscard]] OccupancyGrid make_scene(SceneKind kind, std::uint64_t layout_seed,
                                       std::uint64_t change_seed);

}  // namespace cornerfix::evaluation

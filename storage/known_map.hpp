/// \file  The map that a change starts from, as its caller saw it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <cornerfix/result.hpp>

namespace cornerfix::storage {

struct MapInfo;

struct KnownMap {
  std::uint64_t revision = 0;  ///< 0: there was no map of that name.
  /// A change is refused when the map of that name has another id. 0: not known.
  std::int64_t id = 0;
  /// And when it has another description. Not compared without one.
  std::optional<std::string> description{};
};

/// kConflict, `field` "revision", when `map` is not the known one. Revision 0: there is no map.
[[nodiscard]] Result<void> check_known(const MapInfo& map, const KnownMap& known);

}  // namespace cornerfix::storage

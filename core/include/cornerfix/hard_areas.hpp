/// \file  Where in a map robots will take long to find themselves, why, and what helps.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <cornerfix/localizability.hpp>

namespace cornerfix {

/// Neighbouring places from where robots drive 3 m or more until they are told their pose.
struct HardArea {
  Point2 center_map = Point2::Zero();
  double radius_m = 0.0;            ///< To the farthest of its places.
  std::vector<std::size_t> places;  ///< Ascending indices into the report's.
  double way_m = 0.0;               ///< Mean of what its starts need.
  double found = 0.0;               ///< Share of its starts that are told their pose at all.
  /// Another place that half or more of its starts were taken for, or that could not be excluded;
  /// nothing when too little is seen here instead.
  std::optional<Point2> look_alike_map;
  std::optional<Point2> easy_map;  ///< The nearest place where standing still is enough.
};

/// Hardest first: by the number of places times what they need.
[[nodiscard]] std::vector<HardArea> find_hard_areas(const LocalizabilityReport& report);

}  // namespace cornerfix

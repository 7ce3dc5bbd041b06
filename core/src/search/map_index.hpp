/// \file  What is made from a map's content to search the map and to judge poses in it.
#pragma once

#include <cstddef>
#include <span>

#include <cornerfix/localization_map.hpp>

#include "core/src/map/distance_field.hpp"
#include "core/src/map/evidence_model.hpp"
#include "core/src/matching/descriptor_matcher.hpp"
#include "core/src/matching/triangle_index.hpp"
#include "core/src/search/place_search.hpp"

namespace cornerfix {

/// Immutable. Keeps no reference to what it is made from.
struct MapIndex {
  /// O(cells).
  MapIndex(std::span<const Feature> features, const DescriptorSet& descriptors,
           const OccupancyGrid& grid);

  [[nodiscard]] std::size_t bytes() const;

  DescriptorIndex descriptor_index;
  TriangleIndex triangle_index;
  DistanceField field;
  ClassField classes;
  PlaceSearch place_search;
};

}  // namespace cornerfix

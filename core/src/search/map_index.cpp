#include "core/src/search/map_index.hpp"

namespace cornerfix {

MapIndex::MapIndex(std::span<const Feature> features, const DescriptorSet& descriptors,
                   const OccupancyGrid& grid)
    : descriptor_index(descriptors),
      triangle_index(features, {}),
      field(grid),
      classes(grid, field),
      place_search(classes) {}

std::size_t MapIndex::bytes() const {
  return sizeof(MapIndex) + descriptor_index.bytes() + triangle_index.memory_bytes() +
         field.steps().size() + classes.bytes() + place_search.bytes();
}

}  // namespace cornerfix

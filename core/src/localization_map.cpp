#include <cornerfix/localization_map.hpp>

#include <utility>

namespace cornerfix {

LocalizationMap::LocalizationMap(std::string name, std::uint64_t revision, MapContent content)
    : name_(std::move(name)),
      revision_(revision),
      features_(std::move(content.features)),
      grid_(std::move(content.grid)),
      descriptor_index_(content.descriptors),
      triangle_index_(features_, {}),
      field_(grid_),
      classes_(grid_, field_),
      place_search_(classes_),
      free_area_m2_(grid_.free_area_m2()) {}

std::size_t LocalizationMap::bytes() const {
  return sizeof(LocalizationMap) + features_.size() * sizeof(Feature) +
         grid_.cells.size() * sizeof(Cell) + descriptor_index_.bytes() +
         triangle_index_.memory_bytes() + field_.steps().size() + classes_.bytes() +
         place_search_.bytes();
}

}  // namespace cornerfix

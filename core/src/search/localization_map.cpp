#include <cornerfix/localization_map.hpp>

#include <utility>

#include "core/src/search/map_index.hpp"

namespace cornerfix {

LocalizationMap::LocalizationMap(std::string name, std::uint64_t revision, MapContent content)
    : name_(std::move(name)),
      revision_(revision),
      features_(std::move(content.features)),
      grid_(std::move(content.grid)),
      descriptor_params_(content.descriptors.params),
      free_area_m2_(grid_.free_area_m2()),
      index_(std::make_unique<const MapIndex>(features_, content.descriptors, grid_)) {}
LocalizationMap::~LocalizationMap() = default;
LocalizationMap::LocalizationMap(LocalizationMap&&) noexcept = default;

std::size_t LocalizationMap::bytes() const {
  return sizeof(LocalizationMap) + features_.size() * sizeof(Feature) +
         grid_.cells.size() * sizeof(Cell) + index_->bytes();
}

}  // namespace cornerfix

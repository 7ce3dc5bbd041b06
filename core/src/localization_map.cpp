#include <cornerfix/localization_map.hpp>

#include <utility>

namespace cornerfix {

LocalizationMap::LocalizationMap(std::string name, std::uint64_t revision, MapContent content)
    : name_(std::move(name)),
      revision_(revision),
      content_(std::move(content)),
      descriptor_index_(content_.descriptors),
      field_(content_.grid),
      classes_(content_.grid, field_),
      place_search_(classes_) {}

}  // namespace cornerfix

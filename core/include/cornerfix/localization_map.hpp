/// \file  A stored map, ready to be localized in. Immutable, so any threads may share it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <cornerfix/descriptor_matcher.hpp>
#include <cornerfix/distance_field.hpp>
#include <cornerfix/evidence_model.hpp>
#include <cornerfix/mapper.hpp>
#include <cornerfix/place_search.hpp>

namespace cornerfix {

/// Content of one revision of a map with the distance field made from its grid.
class LocalizationMap {
 public:
  /// O(cells). `content.descriptors` must belong to `content.features`.
  LocalizationMap(std::string name, std::uint64_t revision, MapContent content);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::uint64_t revision() const { return revision_; }
  [[nodiscard]] const std::vector<Feature>& features() const { return content_.features; }
  [[nodiscard]] const DescriptorSet& descriptors() const { return content_.descriptors; }
  [[nodiscard]] const DescriptorIndex& descriptor_index() const { return descriptor_index_; }
  [[nodiscard]] const OccupancyGrid& grid() const { return content_.grid; }
  [[nodiscard]] const DistanceField& field() const { return field_; }
  [[nodiscard]] const ClassField& classes() const { return classes_; }
  [[nodiscard]] const PlaceSearch& place_search() const { return place_search_; }

 private:
  std::string name_;
  std::uint64_t revision_;
  MapContent content_;
  DescriptorIndex descriptor_index_;
  DistanceField field_;
  ClassField classes_;
  PlaceSearch place_search_;
};

using LocalizationMapPtr = std::shared_ptr<const LocalizationMap>;

}  // namespace cornerfix

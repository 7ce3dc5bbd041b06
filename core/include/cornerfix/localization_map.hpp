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
#include <cornerfix/triangle_index.hpp>

namespace cornerfix {

/// Content of one revision of a map with what is made from it to search it and to judge poses.
/// Descriptors are kept only as their index; describe_one() makes one anew.
class LocalizationMap {
 public:
  /// O(cells). `content.descriptors` must belong to `content.features`.
  LocalizationMap(std::string name, std::uint64_t revision, MapContent content);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::uint64_t revision() const { return revision_; }
  [[nodiscard]] const std::vector<Feature>& features() const { return features_; }
  [[nodiscard]] const DescriptorIndex& descriptor_index() const { return descriptor_index_; }
  [[nodiscard]] const TriangleIndex& triangle_index() const { return triangle_index_; }
  [[nodiscard]] const OccupancyGrid& grid() const { return grid_; }
  [[nodiscard]] const DistanceField& field() const { return field_; }
  [[nodiscard]] const ClassField& classes() const { return classes_; }
  [[nodiscard]] const PlaceSearch& place_search() const { return place_search_; }

  /// Known-free space [m^2].
  [[nodiscard]] double free_area_m2() const { return free_area_m2_; }

  /// What it keeps in memory.
  [[nodiscard]] std::size_t bytes() const;

 private:
  std::string name_;
  std::uint64_t revision_;
  std::vector<Feature> features_;
  OccupancyGrid grid_;
  DescriptorIndex descriptor_index_;
  TriangleIndex triangle_index_;
  DistanceField field_;
  ClassField classes_;
  PlaceSearch place_search_;
  double free_area_m2_;
};

using LocalizationMapPtr = std::shared_ptr<const LocalizationMap>;

}  // namespace cornerfix

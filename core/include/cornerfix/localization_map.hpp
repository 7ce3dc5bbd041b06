/// \file  A stored map, ready to be localized in. Immutable, so any threads may share it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <cornerfix/answer.hpp>
#include <cornerfix/corners.hpp>
#include <cornerfix/mapper.hpp>

namespace cornerfix {

struct MapIndex;

/// Content of one revision of a map with what is made from it to search it and to judge poses.
/// Descriptors are kept only as their index; describe_one() makes one anew.
class LocalizationMap {
 public:
  /// O(cells). `content.descriptors` must belong to `content.features`.
  LocalizationMap(std::string name, std::uint64_t revision, MapContent content);
  ~LocalizationMap();
  LocalizationMap(LocalizationMap&&) noexcept;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::uint64_t revision() const { return revision_; }
  [[nodiscard]] const std::vector<Feature>& features() const { return features_; }
  [[nodiscard]] const DescriptorParams& descriptor_params() const { return descriptor_params_; }
  [[nodiscard]] const OccupancyGrid& grid() const { return grid_; }

  /// Known-free space [m^2].
  [[nodiscard]] double free_area_m2() const { return free_area_m2_; }

  /// What it keeps in memory.
  [[nodiscard]] std::size_t bytes() const;

  /// What is made from the content. The type is private to the library.
  [[nodiscard]] const MapIndex& index() const { return *index_; }

 private:
  std::string name_;
  std::uint64_t revision_;
  std::vector<Feature> features_;
  OccupancyGrid grid_;
  DescriptorParams descriptor_params_;
  double free_area_m2_;
  std::unique_ptr<const MapIndex> index_;
};

}  // namespace cornerfix

/// \file  A map put together from submaps at the poses known so far, to look for places in.
#pragma once

#include <span>
#include <vector>

#include "core/src/map/evidence_model.hpp"
#include "core/src/search/place_search.hpp"
#include "core/src/slam/drive_submap.hpp"

namespace cornerfix {

/// Immutable.
class SubmapMosaic {
 public:
  /// `T_map_submap` has the pose of each of `submaps`; there is at least one. O(cells).
  SubmapMosaic(std::span<const DriveSubmap> submaps, std::span<const Pose2> T_map_submap);

  [[nodiscard]] const DistanceField& field() const { return field_; }
  [[nodiscard]] const ClassField& classes() const { return classes_; }
  [[nodiscard]] const PlaceSearch& place_search() const { return place_search_; }
  [[nodiscard]] double free_area_m2() const { return free_area_m2_; }

 private:
  explicit SubmapMosaic(const OccupancyGrid& grid);

  DistanceField field_;
  ClassField classes_;
  PlaceSearch place_search_;
  double free_area_m2_;
};

}  // namespace cornerfix

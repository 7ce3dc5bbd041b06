/// \file  Feature points over many drives: those of the newest one, and of earlier ones those that
/// it has not disproved.
#pragma once

#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>

#include "core/src/features/feature_map.hpp"

namespace cornerfix {

/// Grows by the corners of scans, as FeatureMap does. In a new run (mapping_drive.hpp) a feature
/// shown again stands where that run saw it. One that ten of its scans could have shown and none
/// did is gone. They looked through its place, or saw it from between its walls without a corner
/// there. What the run does not pass stays. Value type; not synchronised. A scan costs O(corners),
/// after the first run O(features).
class FeatureHistory {
 public:
  /// `min_count` is how many scans must show a feature; >= 1.
  FeatureHistory(FeatureMapParams params, int min_count);

  /// The scans from here on are of a later run.
  void begin_drive();

  /// \param corners  Those of `scan`, in this history's frame.
  void insert(std::span<const Feature> corners, const LaserScan& scan, const Pose2& T_map_laser);

  /// The features that enough scans have shown, in a fixed order; counts are over all drives.
  [[nodiscard]] std::vector<Feature> repeated() const;

 private:
  /// A feature of earlier runs.
  struct Earlier {
    Feature feature;
    int looks = 0;  ///< Scans of this run that could have shown it.
  };

  [[nodiscard]] std::vector<Feature> standing() const;

  FeatureMapParams params_;
  int min_count_;
  FeatureMap drive_;  ///< Of the newest run.
  std::vector<Earlier> earlier_;
};

}  // namespace cornerfix

/// \file  Feature points of one frame: corners kept across scans, merged by non-maximum
/// suppression.
///
/// Peng et al. 2023, section 2.2 and the end of algorithm 1.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// A corner of the building. Frame: that of the map that holds it, or `laser` for a corner of one
/// scan.
struct Feature {
  Point2 position = Point2::Zero();  ///< [m]
  double turn_angle = 0.0;  ///< a of eq. (6) [rad]: 0 on a straight wall, pi/2 at a right angle.
  double bisector =
      0.0;              ///< Heading of the bisector of the two arms, into the smaller angle [rad].
  double weight = 0.0;  ///< Score that suppression compares: the largest a seen, by default.
  int count = 1;        ///< Scans that showed it.
};

/// The same corner in the target frame of T.
[[nodiscard]] inline Feature transformed(const Pose2& T, Feature feature) {
  feature.position = T * feature.position;
  feature.bisector = wrap_angle(feature.bisector + T.yaw);
  return feature;
}

struct FeatureMapParams {
  double suppression_radius_m = 0.35;  ///< Corners nearer than this are one feature; > 0.
};

/// Grows by the corners of scans; of near ones the one with the highest weight keeps its place.
/// Value type; not synchronised. Memory O(features); insert is O(1) on average by a cell hash.
class FeatureMap {
 public:
  explicit FeatureMap(FeatureMapParams params = {});

  /// Merges `corners`, given in this map's frame, seen in one scan.
  void insert(std::span<const Feature> corners);

  /// In the order of first sight.
  [[nodiscard]] const std::vector<Feature>& features() const { return features_; }

  /// Those seen in at least `min_count` scans.
  [[nodiscard]] std::vector<Feature> repeated(int min_count) const;

 private:
  FeatureMapParams params_;
  std::vector<Feature> features_;
  struct CellHash;
  std::vector<std::vector<std::size_t>>
      buckets_;  ///< Feature indices by hashed cell of the radius' size.
};

}  // namespace cornerfix

/// \file  From scans at poses to a map: key frames, features, descriptors and an occupancy grid.
///
/// The key frames are the map's source; all else is derived from them and can be made anew, for
/// instance after an optimised trajectory moved them (end of the paper's section 2). Those of a
/// later drive (mapping_drive.hpp) update the map: what is gone where they looked leaves it.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <cornerfix/corner_extractor.hpp>
#include <cornerfix/descriptor.hpp>
#include <cornerfix/feature_history.hpp>
#include <cornerfix/laser_scan.hpp>
#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/occupancy_mapping.hpp>

namespace cornerfix {

struct MapperParams {
  double key_frame_distance_m = 0.15;  ///< A scan this far from the last key frame is one; >= 0.
  double key_frame_angle_rad = 0.14;   ///< Or turned by this much; >= 0.
  int min_feature_count = 2;           ///< Key frames that must show a feature; >= 1.
  CornerExtractor extractor = CornerExtractor::kTwoArm;
  OccupancyMappingParams grid{};
  FeatureMapParams features{};
  DescriptorParams descriptors{};
};

[[nodiscard]] std::optional<Error> validate(const MapperParams& params);

/// What is derived from key frames: all that localizing needs, and nothing else.
struct MapContent {
  std::vector<Feature> features;  ///< In `map`.
  DescriptorSet descriptors;      ///< Of `features`, same order.
  OccupancyGrid grid;             ///< T_map_grid has yaw 0.
};

/// Grows a map scan by scan. Value type; not synchronised.
class Mapper {
 public:
  explicit Mapper(MapperParams params = {});

  /// Why the map cannot take `scan`, or nothing: it would make the grid larger than kMaxCells.
  [[nodiscard]] std::optional<Error> reject(const PosedScan& scan) const;

  /// Whether `scan` is far enough from the last key frame to become one.
  [[nodiscard]] bool is_key_frame(const PosedScan& scan) const;

  /// Adds a key frame, which must not be rejected: its corners join the features. O(beams), and in
  /// a later drive O(features).
  void add(PosedScan key_frame);

  static constexpr double kMaxCells = 1e8;  ///< Of the grid: 500 x 500 m at 0.05 m.

  [[nodiscard]] const std::vector<PosedScan>& key_frames() const { return key_frames_; }
  /// Features that enough key frames have shown so far.
  [[nodiscard]] std::size_t feature_count() const;

  /// What the key frames saw; nothing before the first.
  [[nodiscard]] const std::optional<Bounds>& bounds() const { return bounds_; }

  /// Features, descriptors and grid of all key frames. O(key frames * beams * range / resolution).
  [[nodiscard]] MapContent build() const;

 private:
  MapperParams params_;
  std::vector<PosedScan> key_frames_;
  FeatureHistory features_;
  std::optional<Bounds> bounds_;
};

}  // namespace cornerfix

/// \file  Makes a map from scans at known poses, or from an occupancy map alone.
///
/// The keyframes are the map's source. All else is derived from them and can be made again, for
/// instance after an optimised trajectory moved them (end of the paper's section 2). Those of a
/// later run update the map: what is gone where they looked leaves it. A keyframe begins another
/// run when its stamp is more than five minutes from that of the keyframe before, either way.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <cornerfix/corners.hpp>
#include <cornerfix/laser_scan.hpp>
#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

/// How keyframes become an occupancy grid.
struct OccupancyMappingParams {
  double resolution_m = 0.05;  ///< [m/cell]; > 0.
  double max_range_m = 30.0;   ///< Longer returns are left out: their ends lie too far apart; > 0.
  double min_peak_share = 0.35;  ///< A wall has this share of the most hits around it, else walls
                                 ///< grow thick; in [0, 1].
  double min_hit_share = 0.20;   ///< And this share of the beams that came to it ended there, else
                                 ///< people stay; in [0, 1].
};

[[nodiscard]] std::optional<Error> validate(const OccupancyMappingParams& params);

struct MapperParams {
  double key_frame_distance_m = 0.15;  ///< A scan this far from the last keyframe is one; >= 0.
  double key_frame_angle_rad = 0.14;   ///< Or turned by this much; >= 0.
  int min_feature_count = 2;           ///< Keyframes that must show a feature; >= 1.
  CornerExtractor extractor = CornerExtractor::kLineIntersection;
  OccupancyMappingParams grid{};
  FeatureMapParams features{};
  DescriptorParams descriptors{};
};

[[nodiscard]] std::optional<Error> validate(const MapperParams& params);

/// What is derived from keyframes: all that localizing needs, and nothing else.
struct MapContent {
  std::vector<Feature> features;  ///< In `map`.
  DescriptorSet descriptors;      ///< Of `features`, same order.
  OccupancyGrid grid;             ///< T_map_grid has yaw 0.
};

/// Axis-aligned box in `map` [m].
struct Bounds {
  Point2 min = Point2::Zero();
  Point2 max = Point2::Zero();

  void extend(const Bounds& other) {
    min = min.cwiseMin(other.min);
    max = max.cwiseMax(other.max);
  }
};

/// Where the robot stood and what it saw within max_range_m.
[[nodiscard]] Bounds bounds_of(const PosedScan& scan, const OccupancyMappingParams& params);

class FeatureHistory;

/// Grows a map scan by scan. Movable; not synchronised.
class Mapper {
 public:
  explicit Mapper(MapperParams params = {});
  ~Mapper();
  Mapper(Mapper&&) noexcept;
  Mapper& operator=(Mapper&&) noexcept;

  /// Why the map cannot take `scan`: not finite, or the grid above kMaxCells. Nothing if it can.
  [[nodiscard]] std::optional<Error> reject(const PosedScan& scan) const;

  /// Whether `scan` is far enough from the last keyframe to become one.
  [[nodiscard]] bool is_key_frame(const PosedScan& scan) const;

  /// Adds a keyframe, which must not be rejected: its corners join the features. O(beams), and in
  /// a later run O(features).
  void add(PosedScan key_frame);

  static constexpr double kMaxCells = 1e8;  ///< Of the grid: 500 x 500 m at 0.05 m.

  [[nodiscard]] const std::vector<PosedScan>& key_frames() const { return key_frames_; }
  /// Features that enough keyframes have shown so far.
  [[nodiscard]] std::size_t feature_count() const;

  /// What the keyframes saw; nothing before the first.
  [[nodiscard]] const std::optional<Bounds>& bounds() const { return bounds_; }

  /// Features, descriptors and grid of all keyframes. O(keyframes * beams * range / resolution).
  [[nodiscard]] MapContent build() const;

 private:
  MapperParams params_;
  std::vector<PosedScan> key_frames_;
  std::unique_ptr<FeatureHistory> features_;
  std::optional<Bounds> bounds_;
};

/// A map made from an occupancy map.
struct GridMap {
  MapContent content;                 ///< `grid` is turned as the occupancy map is.
  std::vector<std::string> warnings;  ///< What the map's owner should know; one sentence each.
};

/// The steps of map_from_grid(), in their order.
enum class GridMapStage {
  kWalls,        ///< The surfaces of the walls.
  kFeatures,     ///< Corners of simulated scans: nearly all of the time.
  kDescriptors,  ///< Of the features.
};

/// Called at the beginning of each stage and as it goes on, with the share of the stage that is
/// done, in [0, 1]. The work is given up when it returns false.
using GridMapProgress = std::function<bool(GridMapStage, double)>;

/// Makes a map from an occupancy map alone. Features come from simulated scans in the free space,
/// so they are what a lidar would see there; the grid holds the surfaces of the walls.
///
/// Of `params` the extractor, the features, the descriptors, the grid's resolution and the least
/// count of a feature are used. A count is of simulated scans, one per square metre of free space.
///
/// \return kInvalidArgument for a map without free cells or without walls, kTooLarge for one of
/// more than Mapper::kMaxCells cells at the wanted resolution, kUnavailable when `progress` gave
/// up.
///
/// O(cells + free space), on all cores. Less than 1 s of processor time for 1,000 m2 of free space.
[[nodiscard]] Result<GridMap> map_from_grid(const OccupancyGrid& floor_map,
                                            const MapperParams& params,
                                            const GridMapProgress& progress = {});

}  // namespace cornerfix

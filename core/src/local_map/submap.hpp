/// \file  Scans gathered over a short drive: the paper's local map, which exists with and without
/// odometry.
///
/// Frame `submap` is `base_link` at the first scan. Each scan is matched against those before it;
/// every so often one is kept, and a sliding window forgets those that lie too far back on the way.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>

#include "core/src/features/feature_map.hpp"
#include "core/src/map/tiled_field.hpp"
#include "core/src/matching/scan_refiner.hpp"
#include "core/src/scan/evidence_grid.hpp"

namespace cornerfix {

struct SubmapParams {
  double window_m = 20.0;           ///< Way after which a kept scan is forgotten; > 0.
  double match_window_m = 12.0;     ///< And after which none is matched on it any longer; > 0.
  std::size_t max_scans = 200;      ///< Or so many newer ones: a robot may turn on the spot; > 0.
  double keep_distance_m = 0.25;    ///< A scan this far from the last kept one is kept; > 0.
  double keep_angle_rad = 0.2;      ///< Or turned by this much; > 0.
  double field_resolution_m = 0.1;  ///< Of the field that scans are matched on; > 0.
  double field_extent_m = 50.0;     ///< Its side; walls outside are not matched; > 0.
  double stamp_radius_m =
      0.5;  ///< How far from a wall the field reaches: the basin of the match; > 0.
  EvidenceGridParams evidence{};
  FeatureMapParams features{};
};

/// How far around a pose to look for a better one.
struct SearchWindow {
  double shift_m = 0.3;    ///< To either side, along both axes; >= 0.
  double turn_rad = 0.25;  ///< To either side; >= 0.
};

/// Lasers of a robot are distinguished by where they are mounted.
[[nodiscard]] bool is_same_laser(const Pose2& T_base_link_laser, const Pose2& T_base_link_other);

struct FoundStart {
  Pose2 T_submap_base_link;
  double cost = 0.0;  ///< Mean squared distance of the points to walls, and a little for being far
                      ///< from the middle of the window [m^2].
};

/// Value type; not synchronised.
class Submap {
 public:
  explicit Submap(SubmapParams params = {});

  /// Whether a scan at this pose shows enough new to be kept. Each laser of a robot shows
  /// something else.
  [[nodiscard]] bool wants(const Pose2& T_submap_base_link, const Pose2& T_base_link_laser) const;
  /// Whether it has a scan of this laser.
  [[nodiscard]] bool knows_laser(const Pose2& T_base_link_laser) const;

  /// Keeps a scan with the corners seen in it (in `laser`) and forgets what has left the window.
  /// `scan.index` is given by the submap unless `restored`.
  void keep(SubmapScan scan, std::vector<Feature> corners_laser, bool restored = false);

  /// Lays `points_base_link` on the walls seen so far, starting at the prior. O(points).
  [[nodiscard]] RefinedPose match(std::span<const Point2> points_base_link,
                                  const PosePrior& prior) const {
    return match(points_base_link, prior, prior.T_frame_base_link);
  }
  /// The same, starting elsewhere.
  [[nodiscard]] RefinedPose match(std::span<const Point2> points_base_link, const PosePrior& prior,
                                  const Pose2& start) const;

  /// Information of x, y, yaw that the points give at a matched pose, along the axes of base_link;
  /// singular where they do not constrain it. O(points).
  [[nodiscard]] Eigen::Matrix3d match_information(std::span<const Point2> points_base_link,
                                                  const Pose2& T_submap_base_link) const;

  /// The pose about `middle` whose points lie nearest to walls, for a start that match() would not
  /// find by itself. O(points * shifts^2 * turns).
  [[nodiscard]] FoundStart search(std::span<const Point2> points_base_link, const Pose2& middle,
                                  const SearchWindow& window) const;

  [[nodiscard]] bool empty() const { return kept_.empty(); }
  [[nodiscard]] std::size_t size() const { return kept_.size(); }
  [[nodiscard]] std::vector<SubmapScanPtr> scans() const;
  /// Of base_link at the kept scans.
  [[nodiscard]] std::vector<Pose2> poses() const;
  [[nodiscard]] std::uint64_t next_index() const { return next_index_; }
  void set_next_index(std::uint64_t next) { next_index_ = next; }
  /// In `submap`.
  [[nodiscard]] const std::vector<Feature>& features() const { return features_.features(); }
  /// Of the kept scans. O(cells touched) after a change, else O(1).
  [[nodiscard]] const Evidence& evidence() const;
  /// From now on evidence() costs O(kept scans * beams), but nothing is held for it and keep()
  /// costs less.
  void stop_gathering_evidence();
  /// As at first.
  void gather_evidence();

 private:
  struct Kept {
    SubmapScanPtr scan;
    std::vector<Feature> corners_submap;
    double way_m = 0.0;  ///< Driven up to here.
  };
  /// The last one of a laser; null when there is none.
  [[nodiscard]] const SubmapScan* last_scan_of(const Pose2& T_base_link_laser) const;
  void append_walls_of(const SubmapScan& scan, std::vector<Point2>& walls_grid) const;
  void rebuild_about(const Point2& center);
  [[nodiscard]] EvidenceGrid evidence_of_kept() const;

  SubmapParams params_;
  std::deque<Kept> kept_;
  std::uint64_t next_index_ = 0;
  Point2 center_ = Point2::Zero();  ///< Of the fields.
  TiledField field_;
  std::optional<EvidenceGrid> evidence_grid_;  ///< While evidence is gathered.
  FeatureMap features_;
  mutable std::optional<Evidence> evidence_;
};

}  // namespace cornerfix

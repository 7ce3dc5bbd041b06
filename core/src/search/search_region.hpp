/// \file  The poses that a StartRegion leaves to a robot that has moved since its first scan.
#pragma once

#include <cornerfix/localization_map.hpp>
#include <cornerfix/localizer_params.hpp>
#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// Positions within a circle.
struct Disc {
  Point2 center = Point2::Zero();
  double radius_m = 0.0;
};

/// Value type.
class SearchRegion {
 public:
  /// \param T_start_base_link  Motion of base_link since the first scan.
  explicit SearchRegion(StartRegion start, const Pose2& T_start_base_link = {});

  void move_along(const Pose2& motion) { T_start_base_link_ = T_start_base_link_ * motion; }
  /// For a robot that saw, and so moved, as in a mirror.
  [[nodiscard]] SearchRegion mirrored() const;

  [[nodiscard]] bool is_in(const LocalizationMap& map) const;
  /// Whether the robot may be there now. `slack_m` and `slack_rad` widen the region.
  [[nodiscard]] bool contains(const Pose2& T_map_base_link, double slack_m = 0.0,
                              double slack_rad = 0.0) const;
  /// Whether the robot may have this heading now, within `slack_rad`.
  [[nodiscard]] bool has_heading(double yaw, double slack_rad) const;
  /// Where base_link may be now if its heading is within `slack_rad` of `yaw`.
  [[nodiscard]] Disc positions_at(double yaw, double slack_rad) const;

  /// Known-free space of the region in a map [m^2], times the share of headings that it leaves.
  /// O(cells of the region).
  [[nodiscard]] double free_area_m2(const LocalizationMap& map) const;

 private:
  /// The local map drifts while the robot moves away from the start.
  [[nodiscard]] double radius_m() const;

  StartRegion start_;
  Pose2 T_start_base_link_;
};

}  // namespace cornerfix

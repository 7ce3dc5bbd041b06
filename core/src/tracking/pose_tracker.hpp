/// \file  Follows a robot whose place in the map is known: a filter on the transform between submap
/// and map, and the judgement whether its scans still fit.
///
/// The submap carries the pose from scan to scan; the map only corrects its slow drift. So a scan
/// that shows walls which the map does not know, or knows from their other side, cannot pull the
/// pose away.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include <cornerfix/localization_map.hpp>
#include <cornerfix/pose2.hpp>

#include "core/src/matching/scan_refiner.hpp"

namespace cornerfix {

/// How one scan fits the pose.
enum class TrackingVerdict {
  kFits,       ///< It lies on the walls.
  kMisfits,    ///< It does not.
  kNoReturns,  ///< It shows nothing.
};

/// The pose between a prior and a match that the prior held back. The match moved the pose as if
/// the points gave the `claimed` information; they gave the `observed` one. So a wall does not pull
/// the pose along itself. The principal directions are those of `observed` relative to the prior,
/// with the values m of `observed` and f of `claimed`. In each of them the step is m / (1 + m) of
/// the distance to the walls instead of f / (1 + f). It is never longer than that of the match.
/// docs/method/06-tracking.md, section 6.2.
[[nodiscard]] Pose2 moved_as_observed(const PosePrior& prior, const Pose2& matched,
                                      const PointInformation& information);

/// Value type; keeps no map.
class PoseTracker {
 public:
  PoseTracker() = default;
  explicit PoseTracker(const Pose2& T_map_base_link);
  /// Goes on from what filtered_covariance() and usual_fit() said.
  PoseTracker(const Pose2& T_map_base_link, Eigen::Matrix3d filtered_covariance,
              std::optional<double> usual_fit);

  /// The robot moved by `motion`, from base_link to base_link.
  /// \param noise  Covariance of the motion that scan matching does not remove, along the axes of
  /// base_link after it.
  void predict(const Pose2& motion, const Eigen::Matrix3d& noise);

  /// Lays the scan on the map. \param points  In base_link. \param laser  From where, in base_link.
  TrackingVerdict update(const LocalizationMap& map, std::span<const Point2> points,
                         const Point2& laser);

  [[nodiscard]] const Pose2& T_map_base_link() const { return T_map_base_link_; }
  /// Of x, y, yaw along the axes of the map; what the map itself may be off by is added.
  [[nodiscard]] Eigen::Matrix3d covariance() const;
  /// Standard deviation of the position along its most uncertain direction [m].
  [[nodiscard]] double position_sigma_m() const;
  [[nodiscard]] const Eigen::Matrix3d& filtered_covariance() const { return covariance_; }
  [[nodiscard]] std::optional<double> usual_fit() const { return usual_fit_; }

 private:
  Pose2 T_map_base_link_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
  double distance_m_ = 0.0;          ///< Driven since the last update.
  std::optional<double> usual_fit_;  ///< Share of a scan's ends on mapped ground that are on walls.
};

}  // namespace cornerfix

/// \file  The paper's ICP step: a pose refined so that points come to lie on walls, and its
/// information.
///
/// Gauss-Newton on the distance field with a robust weight. The gradient of the field is the normal
/// of the nearest wall, so a step is one of point-to-line ICP without the search for neighbours.
/// Peng et al. 2023, section 3.3.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include <cornerfix/pose2.hpp>

#include "core/src/map/tiled_field.hpp"

namespace cornerfix {

/// What is known of a pose beforehand, for directions that the points do not show (a bare
/// corridor's axis).
struct PosePrior {
  Pose2 T_frame_base_link;
  Eigen::Matrix3d information;  ///< Of x, y, yaw along the axes of the frame; positive definite.
};

/// Equally sure in all directions; both sigmas > 0.
[[nodiscard]] PosePrior isotropic_prior(const Pose2& T_frame_base_link, double sigma_position_m,
                                        double sigma_yaw_rad);

struct ScanRefinerParams {
  double kernel_m =
      0.10;  ///< Residual at which a point's weight is a quarter (Geman-McClure); > 0.
  double sigma_point_m =
      0.10;                 ///< What a point is worth against the prior and in the covariance; > 0.
  int max_iterations = 10;  ///< >= 1
  double normal_error_rad = 0.0;  ///< Error of the walls' normals, in observed_information(); >= 0.
};

struct RefinedPose {
  Pose2 T_frame_base_link;
  double inlier_share = 0.0;  ///< Share of the points within kernel_m of a wall.
};

/// \param field             A DistanceField or TiledField.
/// \param points_base_link  Points to lay on walls [m].
/// \param T_frame_base_link Start; the frame is the field's (`map` or `submap`).
/// O(iterations * points). Keeps no state.
template <typename Field>
[[nodiscard]] RefinedPose refine_pose(const Field& field, std::span<const Point2> points_base_link,
                                      const Pose2& T_frame_base_link,
                                      const ScanRefinerParams& params,
                                      const std::optional<PosePrior>& prior = std::nullopt);

/// The pose of refine_pose() alone, which costs less.
template <typename Field>
[[nodiscard]] Pose2 aligned_pose(const Field& field, std::span<const Point2> points_base_link,
                                 const Pose2& T_frame_base_link, const ScanRefinerParams& params,
                                 const std::optional<PosePrior>& prior = std::nullopt);

/// Information of x, y, yaw from points matched to walls, along the axes of the frame.
struct PointInformation {
  Eigen::Matrix3d claimed;  ///< As if the normals of the walls were exact.
  /// Without what errors of `normal_error_rad` in the normals add (docs/method/06-tracking.md,
  /// section 6.2). Singular where the points do not constrain the pose (along a bare corridor).
  Eigen::Matrix3d observed;
};

/// Information from points that lie on walls at a pose, without any prior. O(points).
template <typename Field>
[[nodiscard]] PointInformation point_information(const Field& field,
                                                 std::span<const Point2> points_base_link,
                                                 const Pose2& T_frame_base_link,
                                                 const ScanRefinerParams& params);

/// PointInformation::observed alone.
template <typename Field>
[[nodiscard]] Eigen::Matrix3d observed_information(const Field& field,
                                                   std::span<const Point2> points_base_link,
                                                   const Pose2& T_frame_base_link,
                                                   const ScanRefinerParams& params);

}  // namespace cornerfix

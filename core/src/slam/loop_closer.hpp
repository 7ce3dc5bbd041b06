/// \file  Whether a submap of a run lies where the run has been before, and how.
///
/// The submap is searched among the older ones as a robot is searched in a map. There is branch and
/// bound over all poses, refinement, and a decision by the evidence against every other pose.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/src/slam/drive_submap.hpp"
#include "core/src/slam/pose_graph.hpp"
#include "core/src/slam/submap_mosaic.hpp"

namespace cornerfix {

/// How far off a predicted pose may be.
struct DriftBound {
  double position_m = 0.0;
  double yaw_rad = 0.0;
};

/// A place where a submap may lie.
struct FoundPlace {
  Pose2 T_map_submap;
  bool is_near = false;  ///< Within the drift that was to be expected.
};

/// The place where `submap` lies in `mosaic`, or nothing where it may lie elsewhere or on new
/// ground. Places within the drift compete among themselves; farther ones with all others.
[[nodiscard]] std::optional<FoundPlace> find_place(const DriveSubmap& submap,
                                                   const SubmapMosaic& mosaic,
                                                   const Pose2& T_map_submap_predicted,
                                                   const DriftBound& drift);

/// Lays points of frame `from` on the walls of `submap`, from where they are believed to lie. The
/// relation from the submap to `from`, without its indices; nothing when they do not fit.
[[nodiscard]] std::optional<PoseRelation> relate(std::span<const Point2> points_from,
                                                 const DriveSubmap& submap,
                                                 const Pose2& T_submap_from);

}  // namespace cornerfix

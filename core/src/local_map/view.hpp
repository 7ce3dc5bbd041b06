/// \file  What was seen over the last metres, from where the robot is now.
#pragma once

#include <vector>

#include <cornerfix/corners.hpp>
#include <cornerfix/pose2.hpp>

#include "core/src/local_map/submap.hpp"
#include "core/src/scan/evidence_grid.hpp"

namespace cornerfix {

/// In base_link at the last scan.
struct View {
  Evidence evidence;
  std::vector<Point2> way;  ///< Where the robot has been.
  std::vector<Feature> corners;
};

[[nodiscard]] View view_from(const Submap& submap, const Pose2& T_submap_base_link);

/// As a lidar that hangs upside down would have seen it. Without corners.
[[nodiscard]] View mirrored(View view);

}  // namespace cornerfix

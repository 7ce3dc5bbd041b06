/// \file  Overlapping pieces of a mapping run, each short enough to be rigid: what a pose graph
/// moves, and what scans of other pieces are laid on.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>

#include "core/src/map/distance_field.hpp"
#include "core/src/scan/evidence_grid.hpp"

namespace cornerfix {

/// The keyframes [first, end) of a run.
struct DrivePiece {
  std::size_t first = 0;
  std::size_t end = 0;
};

/// Cuts a run so that each keyframe lies in one or two pieces and neighbours overlap by half.
[[nodiscard]] std::vector<DrivePiece> cut_drive(std::span<const PosedScan> drive);

/// A piece as a map of its own. Frame `submap` is base_link at its middle keyframe.
struct DriveSubmap {
  DrivePiece piece;
  Pose2 T_drive_submap;
  double reach_m = 0.0;       ///< No keyframe is farther from the origin.
  std::vector<Point2> way;    ///< Positions of its keyframes, in `submap`.
  DistanceField field;        ///< Walls up to kSubmapRange; frame `submap`.
  Evidence evidence;          ///< In `submap`.
  std::vector<Point2> walls;  ///< Centres of its occupied cells, in `submap`.
  std::vector<Point2> floor;  ///< Centres of free cells, one every kFloorSpacing.
};

inline constexpr double kSubmapRange = 20.0;       ///< Farther returns are left out [m].
inline constexpr double kSubmapResolution = 0.05;  ///< Of `walls` [m/cell].
inline constexpr double kFloorSpacing = 0.2;       ///< [m]

/// O(beams * range / resolution) a keyframe.
[[nodiscard]] DriveSubmap make_drive_submap(std::span<const PosedScan> drive, DrivePiece piece);

}  // namespace cornerfix

/// \file  A scan cut where neighbouring points are far apart; grazing pieces dropped. Step 2 of
/// algorithm 1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix {

struct ScanSegmentParams {
  double gap_m =
      0.15;  ///< Neighbours farther apart than this plus what the range allows are cut; > 0.
  double min_incidence_rad =
      0.14;            ///< Smaller angles between beam and surface are unreliable; in (0, pi/2).
  int min_points = 5;  ///< Shorter segments are dropped; >= 2.
};

[[nodiscard]] std::optional<Error> validate(const ScanSegmentParams& params);

/// A point of a scan with the range it was seen at.
struct ScanPoint {
  Point2 position = Point2::Zero();  ///< In `laser` [m].
  double range = 0.0;                ///< ||h_k|| [m]
  std::uint32_t beam = 0;
};

/// Neighbouring points in beam order.
struct ScanSegment {
  std::vector<ScanPoint> points;
  bool closed = false;  ///< Goes all the way round: the first point is a neighbour of the last.
};

/// Segments by the beam of their first point. A segment that runs across the seam of a full-turn
/// scan is one segment; a beam without return cuts only where its neighbours are far apart.
/// O(beams).
[[nodiscard]] std::vector<ScanSegment> cut_into_segments(const LaserScan& scan,
                                                         const ScanSegmentParams& params);

}  // namespace cornerfix

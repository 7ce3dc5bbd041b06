/// \file  Triangles of near points, to be looked up by their sides.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <cornerfix/pose2.hpp>

#include "core/src/matching/point_grid.hpp"

namespace cornerfix {

/// Which triangles are distinct enough to find a place.
struct TriangleLimits {
  double min_side_m = 0.0;
  double max_side_m = 0.0;
  double tolerance_m = 0.0;  ///< Of a side's length.
};

struct Triangle {
  std::array<double, 3> sides{};   ///< Longest first [m].
  bool counter_clockwise = false;  ///< Along the longest, the middle, the shortest side.
  Pose2 frame;  ///< At the centroid, x along the longest side towards the middle one.
};

/// Nothing for sides out of the limits, for sides so equal that their order is chance, and for
/// nearly no area, where the sense is.
[[nodiscard]] std::optional<Triangle> triangle_of(const Point2& a, const Point2& b, const Point2& c,
                                                  const TriangleLimits& limits);

/// Immutable. Memory: 16 bytes a triangle.
class TriangleTable {
 public:
  /// All triangles within the limits, but for each point only of the `max_neighbors` nearest of
  /// those behind it in the grid. Points must lie within 100 km of each other.
  TriangleTable(const PointGrid& grid, const TriangleLimits& limits, std::size_t max_neighbors);

  /// Adds to `frames` those of the triangles that are `triangle` moved, its sides within the
  /// tolerance.
  void find_congruent(const Triangle& triangle, std::vector<Pose2>& frames) const;

  [[nodiscard]] std::size_t size() const { return stored_.size(); }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  /// All that a congruent triangle needs, without a look at the points.
  struct Stored {
    std::uint16_t longest;  ///< In 2^-16ths of the longest possible side.
    std::uint16_t middle;
    std::uint16_t shortest;
    std::uint16_t heading;  ///< Of the frame, in 2^-16ths of a turn.
    float x;                ///< Of the frame, from origin_ [m].
    float y;
  };
  using BySense = std::array<std::vector<Stored>, 2>;  ///< Clockwise, counter-clockwise.

  [[nodiscard]] Stored stored(const Triangle& triangle) const;
  [[nodiscard]] Pose2 frame_of(const Stored& stored) const;
  [[nodiscard]] BySense collect(const PointGrid& grid, const TriangleLimits& limits,
                                std::size_t max_neighbors) const;
  void sort(const BySense& collected);
  [[nodiscard]] std::size_t row_of(bool counter_clockwise, int longest_bin, int middle_bin) const;

  Point2 origin_;
  double units_per_m_;
  int tolerance_;  ///< In units, like bin_width_.
  int bin_width_;
  int bins_;                            ///< Of a side.
  std::vector<std::uint32_t> offsets_;  ///< Of rows: by sense, longest and middle side.
  std::vector<Stored> stored_;          ///< Between two offsets by ascending shortest side.
};

}  // namespace cornerfix

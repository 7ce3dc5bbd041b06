/// \file  Distance to the nearest wall, by look-up: the field that poses are refined and judged on.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// Distances at the centres of the cells of a grid, a byte a cell, capped. Frame `grid` as in
/// OccupancyGrid. Reading is thread safe; `stamp` is not.
class DistanceField {
 public:
  static constexpr double kStep = 0.01;         ///< Quantisation [m].
  static constexpr double kMaxDistance = 2.55;  ///< Farther is reported as this [m].

  DistanceField() = default;
  /// All cells at kMaxDistance.
  DistanceField(const Pose2& T_frame_grid, double resolution, int width, int height);
  /// Distance transform to the occupied cells. O(cells).
  explicit DistanceField(const OccupancyGrid& grid);

  /// Lowers the cells about a point of frame `grid` to their distance from it, within `radius_m`.
  void stamp(const Point2& point_grid, double radius_m);

  struct Sample {
    double distance = kMaxDistance;    ///< [m]
    Point2 gradient = Point2::Zero();  ///< Away from the wall, in frame `grid`; zero outside.
  };
  /// Bilinear between cell centres; kMaxDistance outside.
  [[nodiscard]] Sample sample(const Point2& point_grid) const;
  /// The distance of sample() alone.
  [[nodiscard]] double distance(const Point2& point_grid) const;
  /// At the nearest cell centre; kMaxDistance outside.
  [[nodiscard]] double nearest(const Point2& point_grid) const {
    const double x = point_grid.x() * inverse_resolution_;
    const double y = point_grid.y() * inverse_resolution_;
    if (!(x >= 0.0 && y >= 0.0 && x < width_ && y < height_)) return kMaxDistance;
    return kStep * static_cast<double>(steps_[index(static_cast<int>(x), static_cast<int>(y))]);
  }

  /// Four cell centres about a point, in units of kStep: `lower[0]` is at the column and row asked
  /// for, `lower[1]` at the next column, `upper` at the next row.
  struct Square {
    const std::uint8_t* lower;
    const std::uint8_t* upper;
  };
  /// Column in [0, width - 1), row in [0, height - 1).
  [[nodiscard]] Square square(int column, int row) const {
    const std::uint8_t* lower = &steps_[index(column, row)];
    return {lower, lower + width_};
  }

  [[nodiscard]] const Pose2& T_grid_frame() const {
    return T_grid_frame_;
  }  ///< From `map` or `submap`.
  [[nodiscard]] double resolution() const { return resolution_; }
  [[nodiscard]] double cells_per_metre() const { return inverse_resolution_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// Row-major, in units of kStep.
  [[nodiscard]] std::span<const std::uint8_t> steps() const { return steps_; }

 private:
  /// The four cell centres about a point, and where it lies between them.
  struct Corners {
    double d00, d10, d01, d11;  ///< By column and row, in units of kStep.
    double fx, fy;
  };
  /// False outside.
  [[nodiscard]] bool corners_of(const Point2& point_grid, Corners& corners) const;
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(column);
  }

  Pose2 T_grid_frame_;
  double resolution_ = 0.0;
  double inverse_resolution_ = 0.0;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> steps_;
};

// In the header, because matching a scan asks for some thousand samples.

inline bool DistanceField::corners_of(const Point2& point_grid, Corners& corners) const {
  const double x = point_grid.x() * inverse_resolution_ - 0.5;
  const double y = point_grid.y() * inverse_resolution_ - 0.5;
  if (x < 0.0 || y < 0.0 || x >= width_ - 1 || y >= height_ - 1) return false;
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const std::uint8_t* lower = &steps_[index(column, row)];
  const std::uint8_t* upper = lower + width_;
  corners = {static_cast<double>(lower[0]),
             static_cast<double>(lower[1]),
             static_cast<double>(upper[0]),
             static_cast<double>(upper[1]),
             x - column,
             y - row};
  return true;
}

inline double DistanceField::distance(const Point2& point_grid) const {
  Corners at;
  if (!corners_of(point_grid, at)) return kMaxDistance;
  const double bottom = at.d00 + at.fx * (at.d10 - at.d00);
  const double top = at.d01 + at.fx * (at.d11 - at.d01);
  return kStep * (bottom + at.fy * (top - bottom));
}

inline DistanceField::Sample DistanceField::sample(const Point2& point_grid) const {
  Corners at;
  if (!corners_of(point_grid, at)) return {};
  const double bottom = at.d00 + at.fx * (at.d10 - at.d00);
  const double top = at.d01 + at.fx * (at.d11 - at.d01);
  const double slope = at.d10 - at.d00;
  const double scale = kStep * inverse_resolution_;
  return {kStep * (bottom + at.fy * (top - bottom)),
          {scale * (slope + at.fy * ((at.d11 - at.d01) - slope)), scale * (top - bottom)}};
}

}  // namespace cornerfix

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

/// Four cell centres about a point, in units of DistanceField::kStep: `lower[0]` and `lower[1]`
/// in one row, `upper[0]` and `upper[1]` in the next.
struct FieldSquare {
  const std::uint8_t* lower;
  const std::uint8_t* upper;
};

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

  /// Lowers the cells about points of frame `grid` to their distance from them, within `radius_m`.
  /// O(points * (radius / resolution)^2 + cells / 256).
  void stamp(std::span<const Point2> points_grid, double radius_m);

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

  /// From a cell to the next column and row. Column in [0, width - 1), row in [0, height - 1).
  [[nodiscard]] FieldSquare square(int column, int row) const {
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

/// The four cells about a point, and where it lies between them.
struct FieldPlace {
  template <typename Field>
  FieldPlace(const Field& field, const Point2& point_grid) {
    const double x = point_grid.x() * field.cells_per_metre() - 0.5;
    const double y = point_grid.y() * field.cells_per_metre() - 0.5;
    is_inside = x >= 0.0 && y >= 0.0 && x < field.width() - 1 && y < field.height() - 1;
    if (!is_inside) return;
    const int column = static_cast<int>(x);
    const int row = static_cast<int>(y);
    const FieldSquare square = field.square(column, row);
    d00 = static_cast<double>(square.lower[0]);
    d10 = static_cast<double>(square.lower[1]);
    d01 = static_cast<double>(square.upper[0]);
    d11 = static_cast<double>(square.upper[1]);
    fx = x - column;
    fy = y - row;
  }
  bool is_inside = false;
  double d00 = 0.0, d10 = 0.0, d01 = 0.0, d11 = 0.0;  ///< By column and row [kStep].
  double fx = 0.0, fy = 0.0;
};

/// Bilinear between the cell centres of a DistanceField or TiledField; kMaxDistance outside.
template <typename Field>
double interpolated_distance(const Field& field, const Point2& point_grid) {
  const FieldPlace at(field, point_grid);
  if (!at.is_inside) return DistanceField::kMaxDistance;
  const double bottom = at.d00 + at.fx * (at.d10 - at.d00);
  const double top = at.d01 + at.fx * (at.d11 - at.d01);
  return DistanceField::kStep * (bottom + at.fy * (top - bottom));
}

inline double DistanceField::distance(const Point2& point_grid) const {
  return interpolated_distance(*this, point_grid);
}

inline DistanceField::Sample DistanceField::sample(const Point2& point_grid) const {
  const FieldPlace at(*this, point_grid);
  if (!at.is_inside) return {};
  const double bottom = at.d00 + at.fx * (at.d10 - at.d00);
  const double top = at.d01 + at.fx * (at.d11 - at.d01);
  const double slope = at.d10 - at.d00;
  const double scale = kStep * inverse_resolution_;
  return {kStep * (bottom + at.fy * (top - bottom)),
          {scale * (slope + at.fy * ((at.d11 - at.d01) - slope)), scale * (top - bottom)}};
}

}  // namespace cornerfix

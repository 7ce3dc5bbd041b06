/// \file  Points by their place, so that those near another are found without a look at the rest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// Immutable. Points fill their bounding box more or less evenly, or queries visit many in vain.
class PointGrid {
 public:
  /// `tolerance_m` is the radius of nearest().
  PointGrid(std::span<const Point2> points, double tolerance_m);

  /// Those given, put in order of their cells.
  [[nodiscard]] const std::vector<Point2>& points() const { return points_; }

  /// The point that `place` may be, as far as the tolerance goes.
  [[nodiscard]] std::optional<Point2> nearest(const Point2& place) const {
    if (!may_hold(place)) return std::nullopt;
    std::optional<Point2> nearest;
    double least = tolerance_m_ * tolerance_m_;
    for_each_within(place, tolerance_m_, [&](std::uint32_t index, double squared_distance) {
      if (squared_distance > least) return;
      least = squared_distance;
      nearest = points_[index];
    });
    return nearest;
  }

  /// Calls visit(index into points(), squared distance) for each point within the radius.
  template <typename Visit>
  void for_each_within(const Point2& center, double radius_m, Visit visit) const {
    if (points_.empty()) return;
    const Point2 reach(radius_m, radius_m);
    const Point2 low = (center - reach - origin_) * cells_per_m_;
    const Point2 high = (center + reach - origin_) * cells_per_m_;
    if (!(high.x() >= 0.0 && high.y() >= 0.0 && low.x() < columns_ && low.y() < rows_)) return;
    const auto first = [](double cell) { return cell > 0.0 ? static_cast<std::size_t>(cell) : 0; };
    const auto last = [](double cell, double cells) {
      return static_cast<std::size_t>(cell < cells ? cell : cells - 1.0);
    };
    const std::size_t last_column = last(high.x(), columns_);
    const std::size_t last_row = last(high.y(), rows_);
    for (std::size_t row = first(low.y()); row <= last_row; ++row) {
      const std::size_t cells = row * static_cast<std::size_t>(columns_);
      // Cells of a row lie side by side.
      const std::uint32_t end = offsets_[cells + last_column + 1];
      for (std::uint32_t i = offsets_[cells + first(low.x())]; i < end; ++i) {
        const double squared_distance = (points_[i] - center).squaredNorm();
        if (squared_distance <= radius_m * radius_m) visit(i, squared_distance);
      }
    }
  }

  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  /// False only if no point lies within the tolerance. Most questions end here, in the cache.
  [[nodiscard]] bool may_hold(const Point2& place) const {
    const Point2 cell = (place - mask_origin_) * mask_cells_per_m_;
    if (!(cell.x() >= 0.0 && cell.y() >= 0.0 && cell.x() < mask_columns_ && cell.y() < mask_rows_))
      return false;
    const std::size_t bit =
        mask_bit(static_cast<std::size_t>(cell.x()), static_cast<std::size_t>(cell.y()));
    return (mask_[bit / 64] >> (bit % 64) & 1U) != 0;
  }
  [[nodiscard]] std::size_t mask_bit(std::size_t column, std::size_t row) const {
    return row * static_cast<std::size_t>(mask_columns_) + column;
  }
  [[nodiscard]] std::size_t cell_of(const Point2& point) const;
  void sort(std::span<const Point2> points);
  void build_mask(Point2 extent);

  double tolerance_m_;

  Point2 origin_ = Point2::Zero();  ///< Lower left corner of the first cell.
  double cells_per_m_ = 1.0;
  double columns_ = 0.0;
  double rows_ = 0.0;
  std::vector<std::uint32_t> offsets_{0};  ///< By cell, where its points begin.
  std::vector<Point2> points_;

  Point2 mask_origin_ = Point2::Zero();
  double mask_cells_per_m_ = 1.0;
  double mask_columns_ = 0.0;
  double mask_rows_ = 0.0;
  std::vector<std::uint64_t> mask_;  ///< A bit for each cell that a point is near to.
};

}  // namespace cornerfix

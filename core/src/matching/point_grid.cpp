#include "core/src/matching/point_grid.hpp"

#include <algorithm>
#include <cmath>

namespace cornerfix {
namespace {

constexpr double kMaskCell = 6.0;     // side of a cell, in tolerances
constexpr double kMaskCells = 128.0;  // a point, at most

}  // namespace

PointGrid::PointGrid(std::span<const Point2> points, double tolerance_m)
    : tolerance_m_(tolerance_m), points_(points.size()) {
  if (points.empty()) return;
  Point2 high = origin_ = points[0];
  for (const Point2& p : points) {
    origin_ = origin_.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // About a point a cell, and no more cells than that where all lie in a line.
  const Point2 extent = high - origin_;
  const auto count = static_cast<double>(points.size());
  const double cell_m = std::max({std::sqrt(extent.prod() / count), extent.sum() / count, 1e-3});
  cells_per_m_ = 1.0 / cell_m;
  columns_ = std::floor(extent.x() * cells_per_m_) + 1.0;
  rows_ = std::floor(extent.y() * cells_per_m_) + 1.0;
  sort(points);
  build_mask(extent);
}

void PointGrid::sort(std::span<const Point2> points) {
  offsets_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  for (const Point2& p : points) ++offsets_[cell_of(p)];
  for (std::size_t cell = 1; cell < offsets_.size(); ++cell) offsets_[cell] += offsets_[cell - 1];
  for (const Point2& p : points) points_[--offsets_[cell_of(p)]] = p;
}

void PointGrid::build_mask(Point2 extent) {
  const Point2 reach(tolerance_m_, tolerance_m_);
  mask_origin_ = origin_ - reach;
  extent += 2.0 * reach;
  // As fine as pays, but not more than 16 bytes a point.
  const double cell_m =
      std::max(kMaskCell * tolerance_m_,
               std::sqrt(extent.prod() / (kMaskCells * static_cast<double>(points_.size()))));
  mask_cells_per_m_ = 1.0 / cell_m;
  mask_columns_ = std::floor(extent.x() * mask_cells_per_m_) + 1.0;
  mask_rows_ = std::floor(extent.y() * mask_cells_per_m_) + 1.0;
  mask_.assign(static_cast<std::size_t>(mask_columns_ * mask_rows_) / 64 + 1, 0);
  for (const Point2& p : points_) {
    const Point2 low = (p - reach - mask_origin_) * mask_cells_per_m_;
    const Point2 high = (p + reach - mask_origin_) * mask_cells_per_m_;
    for (auto row = static_cast<std::size_t>(low.y()); row <= static_cast<std::size_t>(high.y());
         ++row) {
      for (auto column = static_cast<std::size_t>(low.x());
           column <= static_cast<std::size_t>(high.x()); ++column) {
        const std::size_t bit = mask_bit(column, row);
        mask_[bit / 64] |= std::uint64_t{1} << (bit % 64);
      }
    }
  }
}

std::size_t PointGrid::cell_of(const Point2& point) const {
  const Point2 cell = (point - origin_) * cells_per_m_;
  return static_cast<std::size_t>(std::floor(cell.y()) * columns_ + std::floor(cell.x()));
}

std::size_t PointGrid::memory_bytes() const {
  return points_.size() * sizeof(Point2) + offsets_.size() * sizeof(std::uint32_t) +
         mask_.size() * sizeof(std::uint64_t);
}

}  // namespace cornerfix

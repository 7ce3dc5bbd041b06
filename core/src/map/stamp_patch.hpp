/// \file  The distances from points at the cells about them: what stamps lower a field to.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

#include "core/src/map/distance_field.hpp"

namespace cornerfix {

/// Where to stamp, in cells of a field; a cell's centre has whole coordinates.
struct StampPlace {
  double column = 0.0;
  double row = 0.0;
  int first_column = 0;  ///< The square about it, clipped to the field; empty if last < first.
  int last_column = -1;
  int first_row = 0;
  int last_row = -1;
};

/// The square within `reach_cells` of a point in a field of width x height cells.
[[nodiscard]] inline StampPlace stamp_place(const Point2& point_cells, double reach_cells,
                                            int width, int height) {
  const double column = point_cells.x() - 0.5;
  const double row = point_cells.y() - 0.5;
  // Clamped before the conversion: a point may lie farther away than an int can hold.
  const auto first = [&](double middle, double end) {
    return static_cast<int>(std::clamp(std::ceil(middle - reach_cells), 0.0, end));
  };
  const auto last = [&](double middle, double end) {
    return static_cast<int>(std::clamp(std::floor(middle + reach_cells), -1.0, end - 1.0));
  };
  return {column,           row, first(column, width), last(column, width), first(row, height),
          last(row, height)};
}

inline constexpr int kLargestStamp = 16;  ///< Columns and rows of a stamp that is drawn at once.

/// Which square of kLargestStamp x kLargestStamp cells holds the middle of a stamp.
struct StampBlock {
  int column = 0;
  int row = 0;
};
[[nodiscard]] inline StampBlock stamp_block_of(const StampPlace& stamp) {
  return {(stamp.first_column + stamp.last_column) / (2 * kLargestStamp),
          (stamp.first_row + stamp.last_row) / (2 * kLargestStamp)};
}

/// The squared distances to the nearest of some points, at cells about them. Distances are compared
/// squared, so that a root is taken once per cell and not once per point.
class StampSquares {
 public:
  /// Columns and rows of the cells that it has: enough for all stamps of a block.
  static constexpr int kSide = 2 * kLargestStamp;

  StampSquares() { squares_.fill(kFar); }

  [[nodiscard]] bool is_empty() const { return last_row_ < first_row_; }
  [[nodiscard]] int first_column() const { return first_column_; }
  [[nodiscard]] int last_column() const { return last_column_; }
  [[nodiscard]] int first_row() const { return first_row_; }
  [[nodiscard]] int last_row() const { return last_row_; }
  /// The cells of one of its rows, from first_column() on.
  [[nodiscard]] const float* row(int row) const { return &squares_[place(first_column_, row)]; }

  [[nodiscard]] bool has_room_for(const StampPlace& stamp) const {
    return stamp.first_column >= left_ && stamp.last_column < left_ + kSide &&
           stamp.first_row >= bottom_ && stamp.last_row < bottom_ + kSide;
  }

  void add(const StampPlace& stamp) {
    using Row = Eigen::Array<float, kLargestStamp, 1>;  // For its vector instructions.
    Row across;
    for (int i = 0; i < kLargestStamp; ++i) {
      const int column = stamp.first_column + i;
      const auto dx = static_cast<float>(column - stamp.column);
      across[i] = column <= stamp.last_column ? dx * dx : kFar;
    }
    for (int row = stamp.first_row; row <= stamp.last_row; ++row) {
      const auto dy = static_cast<float>(row - stamp.row);
      Eigen::Map<Row> squares(&squares_[place(stamp.first_column, row)]);
      squares = squares.min(across + dy * dy);
    }
    include(stamp);
  }

  /// Forgets all stamps, for `next` and others of the same block.
  void restart(const StampPlace& next) {
    for (int row = first_row_; row <= last_row_; ++row)
      std::fill_n(&squares_[place(left_, row)], kStride, kFar);
    const StampBlock around = stamp_block_of(next);
    left_ = around.column * kLargestStamp - (kSide - kLargestStamp) / 2;
    bottom_ = around.row * kLargestStamp - (kSide - kLargestStamp) / 2;
    first_column_ = left_ + kSide;
    last_column_ = left_ - 1;
    first_row_ = bottom_ + kSide;
    last_row_ = bottom_ - 1;
  }

 private:
  /// A row of a stamp is always as long as that of the largest one.
  static constexpr int kStride = kSide + kLargestStamp;
  static constexpr float kFar = 1e12F;

  void include(const StampPlace& stamp) {
    first_column_ = std::min(first_column_, stamp.first_column);
    last_column_ = std::max(last_column_, stamp.last_column);
    first_row_ = std::min(first_row_, stamp.first_row);
    last_row_ = std::max(last_row_, stamp.last_row);
  }
  [[nodiscard]] std::size_t place(int column, int row) const {
    return static_cast<std::size_t>((row - bottom_) * kStride + column - left_);
  }

  int left_ = 0;
  int bottom_ = 0;
  int first_column_ = kSide;  ///< Of the cells that were stamped.
  int last_column_ = -1;
  int first_row_ = kSide;
  int last_row_ = -1;
  std::array<float, static_cast<std::size_t>(kSide) * kStride> squares_;
};

/// The distances at the cells of some stamps. Rows are padded with 255, so that a field can lower a
/// whole row of cells at once wherever it begins.
class StampPatch {
 public:
  static constexpr int kPadding = 16;

  /// \param steps_per_cell  Units of a distance per cell.
  StampPatch(const StampSquares& squares, float steps_per_cell)
      : first_column_(squares.first_column()),
        last_column_(squares.last_column()),
        first_row_(squares.first_row()),
        last_row_(squares.last_row()) {
    const auto columns = static_cast<std::size_t>(last_column_ - first_column_ + 1);
    for (int row = first_row_; row <= last_row_; ++row) {
      const float* from = squares.row(row);
      std::uint8_t* to = &cells_[offset(row)];
      std::fill_n(to, kStride, std::uint8_t{255});
      to += kPadding;
      for (std::size_t i = 0; i < columns; ++i) {
        const float exact = std::sqrt(from[i]) * steps_per_cell;
        to[i] = static_cast<std::uint8_t>(static_cast<int>(exact < 255.0F ? exact : 255.0F));
      }
    }
  }

  [[nodiscard]] int first_column() const { return first_column_; }
  [[nodiscard]] int last_column() const { return last_column_; }
  [[nodiscard]] int first_row() const { return first_row_; }
  [[nodiscard]] int last_row() const { return last_row_; }

  /// The cells of one of its rows from `column` on: kPadding + 1 of them.
  /// \param column  In [first_column() - kPadding, last_column()].
  [[nodiscard]] const std::uint8_t* cells(int column, int row) const {
    return &cells_[offset(row) + static_cast<std::size_t>(column - first_column_ + kPadding)];
  }

 private:
  static constexpr std::size_t kStride = StampSquares::kSide + 2 * kPadding + 1;

  [[nodiscard]] std::size_t offset(int row) const {
    return static_cast<std::size_t>(row - first_row_) * kStride;
  }

  int first_column_;
  int last_column_;
  int first_row_;
  int last_row_;
  std::array<std::uint8_t, kStride * StampSquares::kSide> cells_;  // As many rows as there are.
};

/// Calls `add` with the parts of a stamp that are small enough for StampSquares.
template <typename Add>
void for_each_part(const StampPlace& stamp, const Add& add) {
  StampPlace part = stamp;
  for (int row = stamp.first_row; row <= stamp.last_row; row += kLargestStamp) {
    part.first_row = row;
    part.last_row = std::min(stamp.last_row, row + kLargestStamp - 1);
    for (int column = stamp.first_column; column <= stamp.last_column; column += kLargestStamp) {
      part.first_column = column;
      part.last_column = std::min(stamp.last_column, column + kLargestStamp - 1);
      add(part);
    }
  }
}

/// The same stamps, neighbours side by side. O(stamps + width * height / kLargestStamp^2).
[[nodiscard]] inline std::vector<StampPlace> by_block(std::span<const StampPlace> stamps, int width,
                                                      int height) {
  const int columns = width / kLargestStamp + 1;
  const int rows = height / kLargestStamp + 1;
  const auto number_of = [columns](const StampPlace& stamp) {
    const StampBlock around = stamp_block_of(stamp);
    return static_cast<std::size_t>(around.row * columns + around.column);
  };
  std::vector<std::size_t> begins(static_cast<std::size_t>(columns * rows) + 1);
  for (const StampPlace& stamp : stamps) ++begins[number_of(stamp) + 1];
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<StampPlace> sorted(stamps.size());
  for (const StampPlace& stamp : stamps) sorted[begins[number_of(stamp)]++] = stamp;
  return sorted;
}

/// Calls `lower` with patches that hold the stamps of all points of frame `grid`. Those near each
/// other share one. Field: DistanceField or TiledField.
template <typename Field, typename Lower>
void for_each_patch(const Field& field, std::span<const Point2> points_grid, double radius_m,
                    const Lower& lower) {
  const double reach_cells = radius_m * field.cells_per_metre();
  std::vector<StampPlace> stamps;
  stamps.reserve(points_grid.size());
  for (const Point2& point : points_grid) {
    const Point2 point_cells = point * field.cells_per_metre();
    for_each_part(stamp_place(point_cells, reach_cells, field.width(), field.height()),
                  [&](const StampPlace& part) { stamps.push_back(part); });
  }
  const auto steps_per_cell = static_cast<float>(field.resolution() / DistanceField::kStep);
  StampSquares squares;
  for (const StampPlace& stamp : by_block(stamps, field.width(), field.height())) {
    if (!squares.has_room_for(stamp)) {
      if (!squares.is_empty()) lower(StampPatch(squares, steps_per_cell));
      squares.restart(stamp);
    }
    squares.add(stamp);
  }
  if (!squares.is_empty()) lower(StampPatch(squares, steps_per_cell));
}

}  // namespace cornerfix

/// \file  The distances from a point at the cells about it: what a stamp lowers a field to.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <cornerfix/pose2.hpp>

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
  return {column,
          row,
          std::max(0, static_cast<int>(std::ceil(column - reach_cells))),
          std::min(width - 1, static_cast<int>(std::floor(column + reach_cells))),
          std::max(0, static_cast<int>(std::ceil(row - reach_cells))),
          std::min(height - 1, static_cast<int>(std::floor(row + reach_cells)))};
}

/// Up to kSide x kSide cells of such a square. Rows are padded with 255, so that a field can lower
/// a whole row of cells at once wherever it begins.
class StampPatch {
 public:
  static constexpr int kSide = 16;

  /// The cells of the square from this one on. \param steps_per_cell  Units of a distance per cell.
  StampPatch(const StampPlace& place, int first_column, int first_row, float steps_per_cell)
      : first_column_(first_column),
        first_row_(first_row),
        last_column_(std::min(place.last_column, first_column + kSide - 1)),
        last_row_(std::min(place.last_row, first_row + kSide - 1)) {
    std::array<float, kSide> across;
    for (int i = 0; i < kSide; ++i) {
      const auto dx = static_cast<float>(first_column + i - place.column);
      across[static_cast<std::size_t>(i)] = first_column + i <= last_column_ ? dx * dx : kFar;
    }
    std::array<float, kCells> squares;
    for (int row = first_row; row <= last_row_; ++row) {
      const auto dy = static_cast<float>(row - place.row);
      float* squares_of_row = &squares[static_cast<std::size_t>(row - first_row) * kSide];
      for (std::size_t i = 0; i < kSide; ++i) squares_of_row[i] = across[i] + dy * dy;
    }
    draw(squares, steps_per_cell);
  }

  [[nodiscard]] int first_column() const { return first_column_; }
  [[nodiscard]] int last_column() const { return last_column_; }
  [[nodiscard]] int first_row() const { return first_row_; }
  [[nodiscard]] int last_row() const { return last_row_; }

  /// The cells of one of its rows from `column` on: kSide + 1 of them.
  /// \param column  In [first_column() - kSide, last_column()].
  [[nodiscard]] const std::uint8_t* cells(int column, int row) const {
    return &cells_[offset(row) + static_cast<std::size_t>(column - first_column_ + kSide)];
  }

 private:
  static constexpr std::size_t kCells = static_cast<std::size_t>(kSide) * kSide;
  static constexpr std::size_t kStride = 3 * kSide + 1;
  static constexpr float kFar = 1e12F;

  /// From the squared distances of all cells, row by row. Their number is not known to the
  /// compiler, which would unroll a loop of known length instead of using vectors.
  void draw(const std::array<float, kCells>& squares, float steps_per_cell) {
    const auto rows = static_cast<std::size_t>(last_row_ - first_row_ + 1);
    std::array<std::uint8_t, kCells> steps;
    for (std::size_t i = 0; i < rows * kSide; ++i) {
      const float exact = std::sqrt(squares[i]) * steps_per_cell;
      steps[i] = static_cast<std::uint8_t>(static_cast<int>(exact < 255.0F ? exact : 255.0F));
    }
    for (std::size_t row = 0; row < rows; ++row) {
      std::uint8_t* cells = &cells_[row * kStride];
      std::fill_n(cells, kStride, std::uint8_t{255});
      std::copy_n(&steps[row * kSide], kSide, cells + kSide);
    }
  }
  [[nodiscard]] std::size_t offset(int row) const {
    return static_cast<std::size_t>(row - first_row_) * kStride;
  }

  int first_column_;
  int first_row_;
  int last_column_;
  int last_row_;
  std::array<std::uint8_t, kStride * kSide> cells_;  // As many rows as there are.
};

/// Calls `lower` with the patches that make up a stamp.
template <typename Lower>
void for_each_patch(const StampPlace& place, float steps_per_cell, const Lower& lower) {
  for (int row = place.first_row; row <= place.last_row; row += StampPatch::kSide) {
    for (int column = place.first_column; column <= place.last_column;
         column += StampPatch::kSide) {
      lower(StampPatch(place, column, row, steps_per_cell));
    }
  }
}

}  // namespace cornerfix

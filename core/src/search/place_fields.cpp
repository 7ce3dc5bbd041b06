#include "core/src/search/place_fields.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cornerfix {
namespace {

constexpr double kWantedCell = 0.2;  // [m]

using ValueOfClass = std::array<std::uint8_t, 256>;

std::uint8_t quantised(double weight) {
  return static_cast<std::uint8_t>(
      std::clamp(std::lround((weight - kLowestWeight) * kStepsPerNat), 0L, long{kHighestValue}));
}

ValueOfClass end_values() {
  ValueOfClass values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = (i & 15U) < kFieldClasses
                    ? quantised(static_cast<double>(kSearchWeights.ends[i & 15U]))
                    : 0;
  }
  return values;
}

ValueOfClass way_values() {
  ValueOfClass values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto pass = static_cast<PassClass>(i >> 4U);
    values[i] = pass == PassClass::kUnknown  ? kWayUnknown
                : pass == PassClass::kOnWall ? kWayBlocked
                                             : kWayFree;
  }
  return values;
}

/// The best value near each cell of the map proper. Points and poses are rounded to cells, half a
/// cell either way, and a bound must be no less than the best within that.
std::vector<std::uint8_t> pooled(const ClassField& classes, const PlaceFields& fields,
                                 const ValueOfClass& value_of_class) {
  const int fine_per_cell = static_cast<int>(std::lround(fields.cell_m / classes.resolution()));
  const int margin = (fine_per_cell + 1) / 2;
  const auto at = [](int column, int row, int width) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  };
  std::vector<std::uint8_t> by_row(at(0, classes.height(), fields.inner_width));
  for (int row = 0; row < classes.height(); ++row) {
    for (int column = 0; column < fields.inner_width; ++column) {
      std::uint8_t best = 0;
      const int end = std::min(classes.width(), (column + 1) * fine_per_cell + margin);
      for (int c = std::max(0, column * fine_per_cell - margin); c < end; ++c)
        best = std::max(best, value_of_class[classes.packed(c, row)]);
      by_row[at(column, row, fields.inner_width)] = best;
    }
  }
  std::vector<std::uint8_t> cells(at(0, fields.height, fields.width),
                                  value_of_class[ClassField::kOutside]);
  for (int row = 0; row < fields.inner_height; ++row) {
    std::uint8_t* target = &cells[at(kBorder, row + kBorder, fields.width)];
    std::fill_n(target, fields.inner_width, std::uint8_t{0});
    const int end = std::min(classes.height(), (row + 1) * fine_per_cell + margin);
    for (int r = std::max(0, row * fine_per_cell - margin); r < end; ++r) {
      const std::uint8_t* source = &by_row[at(0, r, fields.inner_width)];
      for (int column = 0; column < fields.inner_width; ++column)
        target[column] = std::max(target[column], source[column]);
    }
  }
  return cells;
}

BlockField field_of(const ClassField& classes, const PlaceFields& fields,
                    const ValueOfClass& values) {
  return {pooled(classes, fields, values), fields.width, fields.height,
          values[ClassField::kOutside]};
}

}  // namespace

BlockField::BlockField(std::span<const std::uint8_t> cells, int width, int height,
                       std::uint8_t outside)
    : width_(width), height_(height), quads_(cells.size()), maxima_(cells.size()) {
  const auto at = [&](std::ptrdiff_t x, std::ptrdiff_t y) {
    return x < width_ && y < height_ ? cells[static_cast<std::size_t>(y * width_ + x)] : outside;
  };
  for (std::ptrdiff_t y = 0; y < height_; ++y) {
    for (std::ptrdiff_t x = 0; x < width_; ++x) {
      const std::array<std::uint8_t, 4> four{at(x, y), at(x + 1, y), at(x, y + 1),
                                             at(x + 1, y + 1)};
      quads_[static_cast<std::size_t>(y * width_ + x)] = four[0] | std::uint32_t{four[1]} << 8U |
                                                         std::uint32_t{four[2]} << 16U |
                                                         std::uint32_t{four[3]} << 24U;
      maxima_[static_cast<std::size_t>(maxima_from(x, y) - maxima_.data())] =
          *std::max_element(four.begin(), four.end());
    }
  }
}

const std::uint8_t* BlockField::maxima_from(std::ptrdiff_t x, std::ptrdiff_t y) const {
  const std::ptrdiff_t phase = (y % kBlock) * kBlock + x % kBlock;
  const std::ptrdiff_t row = phase * (height_ / kBlock) + y / kBlock;
  return &maxima_[static_cast<std::size_t>(row * (width_ / kBlock) + x / kBlock)];
}

PlaceFields::PlaceFields(const ClassField& classes) : T_map_grid(inverse(classes.T_grid_map())) {
  const int fine_per_cell =
      std::max(1, static_cast<int>(std::lround(kWantedCell / classes.resolution())));
  cell_m = fine_per_cell * classes.resolution();
  inner_width = (classes.width() + fine_per_cell - 1) / fine_per_cell;
  inner_height = (classes.height() + fine_per_cell - 1) / fine_per_cell;
  const auto with_border = [](int cells) {
    return (cells + kBlock - 1) / kBlock * kBlock + 2 * kBorder + kBlock;
  };
  width = with_border(inner_width);
  height = with_border(inner_height);
  ends = field_of(classes, *this, end_values());
  way = field_of(classes, *this, way_values());
  nothing.assign(ends.blocks_a_row() * static_cast<std::size_t>(height / kBlock), 0);
}

}  // namespace cornerfix

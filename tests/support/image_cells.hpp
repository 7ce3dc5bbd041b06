/// \file  Bytes of images, and the cells that are read from them as text.
#pragma once

#include <initializer_list>
#include <string>

#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix::testing {

inline std::string bytes(std::initializer_list<int> values) {
  std::string out;
  for (const int value : values) out.push_back(static_cast<char>(value));
  return out;
}

/// The cells as text, highest row first: '.' free, '#' occupied, '?' unknown.
inline std::string drawn(const OccupancyGrid& grid) {
  std::string out;
  for (int row = grid.height - 1; row >= 0; --row) {
    for (int column = 0; column < grid.width; ++column) {
      out += ".#?"[static_cast<int>(grid.at({column, row}))];
    }
    if (row > 0) out += '/';
  }
  return out;
}

inline std::string drawn(const Result<OccupancyGrid>& grid) {
  return grid ? drawn(*grid) : grid.error().field + ": " + grid.error().message;
}

}  // namespace cornerfix::testing

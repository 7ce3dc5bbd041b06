/// \file  Files of the BMP format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace cornerfix::testing {

inline std::string little_endian(std::uint64_t value, std::size_t bytes) {
  std::string out;
  for (std::size_t i = 0; i < bytes; ++i) {
    out.push_back(static_cast<char>(value));
    value >>= 8U;
  }
  return out;
}

/// A bitmap; `palette` of blue, green, red and nothing; `rows` padded, the lowest first unless the
/// height is negative.
inline std::string make_bmp(int width, int height, int bits, const std::string& palette,
                            const std::string& rows, std::uint32_t compression = 0) {
  const std::size_t pixels_at = 54 + palette.size();
  return "BM" + little_endian(pixels_at + rows.size(), 4) + little_endian(0, 4) +
         little_endian(pixels_at, 4) + little_endian(40, 4) +
         little_endian(static_cast<std::uint32_t>(width), 4) +
         little_endian(static_cast<std::uint32_t>(height), 4) + little_endian(1, 2) +
         little_endian(static_cast<std::uint32_t>(bits), 2) + little_endian(compression, 4) +
         little_endian(0, 12) + little_endian(palette.size() / 4, 4) + little_endian(0, 4) +
         palette + rows;
}

}  // namespace cornerfix::testing

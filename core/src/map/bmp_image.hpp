/// \file  Uncompressed Windows bitmaps, as map editors save them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/result.hpp>

namespace cornerfix {

/// A view of a file in memory, which must outlive it. Takes palettes of 1, 4 and 8 bits per pixel,
/// and 24 and 32 bits; of 32 bits the byte that is no colour is not used. Nothing is allocated for
/// pixels.
class BmpImage {
 public:
  /// `field` of an error is "image". All pixels are in the file if there is none.
  [[nodiscard]] static Result<BmpImage> open(std::span<const std::byte> file);
  [[nodiscard]] static bool is_bmp(std::span<const std::byte> file);

  [[nodiscard]] std::int64_t width() const { return width_; }
  [[nodiscard]] std::int64_t height() const { return height_; }
  /// Mean of red, green and blue in [0, 1]; row 0 is the uppermost.
  [[nodiscard]] double brightness(std::int64_t row, std::int64_t column) const;

 private:
  std::int64_t width_ = 0;
  std::int64_t height_ = 0;
  bool is_top_down_ = false;
  int bits_ = 0;                       ///< Per pixel.
  std::size_t first_colour_byte_ = 0;  ///< Of a pixel of 32 bits.
  std::size_t stride_ = 0;
  std::span<const std::byte> pixels_;
  std::array<double, 256> palette_{};  ///< Brightness.
};

}  // namespace cornerfix

/// \file  A colour picture that is drawn pixel by pixel and written as png.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cornerfix::evaluation {

using Rgb = std::array<std::uint8_t, 3>;

/// Row 0 is at the top.
class PngImage {
 public:
  PngImage(int width, int height, Rgb background);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// Pixels outside of the picture are left out.
  void set(int x, int y, Rgb color);
  [[nodiscard]] Rgb at(int x, int y) const;

  /// A whole png file: 8 bits per channel, no alpha.
  [[nodiscard]] std::string encode() const;

 private:
  [[nodiscard]] std::size_t offset(int x, int y) const;

  int width_;
  int height_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace cornerfix::evaluation

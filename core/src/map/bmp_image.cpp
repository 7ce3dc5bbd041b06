#include "core/src/map/bmp_image.hpp"

#include <algorithm>
#include <bit>
#include <optional>
#include <string>

namespace cornerfix {

namespace {

constexpr std::size_t kFileHeaderBytes = 14;
constexpr std::size_t kInfoHeaderBytes = 40;

Error malformed(const std::string& what) {
  return {ErrorCode::kMalformed, "bmp: " + what, "image"};
}

/// Little-endian, within the file.
std::uint32_t number(std::span<const std::byte> file, std::size_t at, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    value |= std::to_integer<std::uint32_t>(file[at + i]) << (8 * i);
  }
  return value;
}

double brightness_of(std::span<const std::byte> blue_green_red) {
  int sum = 0;
  for (const std::byte part : blue_green_red.first(3)) sum += std::to_integer<int>(part);
  return sum / 3.0 / 255.0;
}

/// The byte of a pixel at which its three colours begin, by the masks of red, green and blue. GIMP
/// puts the alpha in front of them. Nothing where colours are no three bytes in a row.
std::optional<std::size_t> first_colour_byte(std::span<const std::byte> file) {
  constexpr std::size_t kMasksAt = kFileHeaderBytes + kInfoHeaderBytes;
  constexpr std::size_t kMaskBytes = 4;
  if (file.size() < kMasksAt + 3 * kMaskBytes) return std::nullopt;
  std::uint32_t colours = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t mask = number(file, kMasksAt + i * kMaskBytes, kMaskBytes);
    const bool is_byte = std::popcount(mask) == 8 && std::countr_zero(mask) % 8 == 0 &&
                         (mask >> static_cast<unsigned>(std::countr_zero(mask))) == 0xffU;
    if (!is_byte) return std::nullopt;
    colours |= mask;
  }
  if (colours == 0x00ffffffU) return 0;
  if (colours == 0xffffff00U) return 1;
  return std::nullopt;
}

}  // namespace

bool BmpImage::is_bmp(std::span<const std::byte> file) {
  return file.size() >= kFileHeaderBytes + kInfoHeaderBytes && file[0] == std::byte{'B'} &&
         file[1] == std::byte{'M'};
}

Result<BmpImage> BmpImage::open(std::span<const std::byte> file) {
  if (!is_bmp(file)) return malformed("ends within its header");
  const std::size_t pixels_at = number(file, 10, 4);
  const std::size_t info_bytes = number(file, kFileHeaderBytes, 4);
  const auto height = static_cast<std::int32_t>(number(file, 22, 4));
  const std::uint32_t compression = number(file, 30, 4);
  constexpr std::uint32_t kBitFields = 3;
  BmpImage image;
  image.width_ = static_cast<std::int32_t>(number(file, 18, 4));
  image.is_top_down_ = height < 0;
  image.height_ = image.is_top_down_ ? -std::int64_t{height} : std::int64_t{height};
  image.bits_ = static_cast<int>(number(file, 28, 2));
  if (info_bytes < kInfoHeaderBytes) return malformed("a header of OS/2, expected that of Windows");
  if (compression != 0 && !(compression == kBitFields && image.bits_ == 32)) {
    return malformed("compressed, expected plain pixels");
  }
  if (compression == kBitFields) {
    const auto first = first_colour_byte(file);
    if (!first) return malformed("masks of other colours than bytes for red, green and blue");
    image.first_colour_byte_ = *first;
  }
  if (image.width_ < 1 || image.height_ < 1) return malformed("an image without pixels");
  const bool has_palette = image.bits_ == 1 || image.bits_ == 4 || image.bits_ == 8;
  if (!has_palette && image.bits_ != 24 && image.bits_ != 32) {
    return malformed(std::to_string(image.bits_) + " bits per pixel, expected 1, 4, 8, 24 or 32");
  }
  if (has_palette) {
    const std::size_t all_colours = std::size_t{1} << image.bits_;
    const std::size_t told = number(file, 46, 4);
    const std::size_t colours = told == 0 || told > all_colours ? all_colours : told;
    const std::size_t palette_at = kFileHeaderBytes + info_bytes;
    if (palette_at > file.size() || colours * 4 > file.size() - palette_at) {
      return malformed("ends within its palette");
    }
    for (std::size_t i = 0; i < colours; ++i) {
      image.palette_[i] = brightness_of(file.subspan(palette_at + 4 * i, 4));
    }
  }
  constexpr std::uint64_t kRowAlignmentBits = 32;
  const auto row_bits =
      static_cast<std::uint64_t>(image.width_) * static_cast<std::uint64_t>(image.bits_);
  image.stride_ = (row_bits + kRowAlignmentBits - 1) / kRowAlignmentBits * 4;
  const std::size_t available = file.size() - std::min(file.size(), pixels_at);
  if (available / image.stride_ < static_cast<std::uint64_t>(image.height_)) {
    return malformed("the file ends before the last pixel");
  }
  image.pixels_ = file.subspan(pixels_at);
  return image;
}

double BmpImage::brightness(std::int64_t row, std::int64_t column) const {
  const auto file_row = static_cast<std::size_t>(is_top_down_ ? row : height_ - 1 - row);
  const auto bit = static_cast<std::size_t>(column) * static_cast<std::size_t>(bits_);
  const auto from = pixels_.subspan(file_row * stride_ + bit / 8);
  if (bits_ > 8) return brightness_of(from.subspan(first_colour_byte_));
  // The first pixel of a byte is in its highest bits.
  const auto shift = 8 - static_cast<unsigned>(bits_) - static_cast<unsigned>(bit % 8);
  const unsigned mask = (1U << static_cast<unsigned>(bits_)) - 1U;
  return palette_[(std::to_integer<unsigned>(from.front()) >> shift) & mask];
}

}  // namespace cornerfix

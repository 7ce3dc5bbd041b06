#include "evaluation/metrics/png_image.hpp"

#include <zlib.h>

#include <algorithm>
#include <cassert>

namespace cornerfix::evaluation {

namespace {

constexpr int kChannels = 3;

void append_number(std::string& out, std::uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(number >> shift & 0xffU);
}

/// Length, type, data and the checksum of type and data.
void append_chunk(std::string& out, const std::string& type, const std::string& data) {
  const std::string body = type + data;
  append_number(out, static_cast<std::uint32_t>(data.size()));
  out += body;
  append_number(out,
                static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(body.data()),
                                                 static_cast<uInt>(body.size()))));
}

std::string compressed(const std::string& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(size, '\0');
  const int status =
      compress(reinterpret_cast<Bytef*>(out.data()), &size,
               reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()));
  assert(status == Z_OK && "the buffer has the size that zlib asked for");
  static_cast<void>(status);
  out.resize(size);
  return out;
}

}  // namespace

PngImage::PngImage(int width, int height, Rgb background) : width_(width), height_(height) {
  assert(width > 0 && height > 0);
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  pixels_.reserve(kChannels * pixels);
  for (std::size_t i = 0; i < pixels; ++i)
    pixels_.insert(pixels_.end(), background.begin(), background.end());
}

void PngImage::set(int x, int y, Rgb color) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  std::ranges::copy(color, pixels_.begin() + static_cast<std::ptrdiff_t>(offset(x, y)));
}

Rgb PngImage::at(int x, int y) const {
  assert(x >= 0 && y >= 0 && x < width_ && y < height_);
  const std::size_t begin = offset(x, y);
  return {pixels_[begin], pixels_[begin + 1], pixels_[begin + 2]};
}

std::string PngImage::encode() const {
  std::string rows;
  const std::size_t row_bytes = kChannels * static_cast<std::size_t>(width_);
  for (int y = 0; y < height_; ++y) {
    rows += '\0';  // no filter
    rows.append(reinterpret_cast<const char*>(pixels_.data()) + offset(0, y), row_bytes);
  }
  std::string header;
  append_number(header, static_cast<std::uint32_t>(width_));
  append_number(header, static_cast<std::uint32_t>(height_));
  header += std::string("\x08\x02\x00\x00\x00", 5);  // depth, RGB, and the usual methods
  std::string out("\x89PNG\r\n\x1a\n", 8);
  append_chunk(out, "IHDR", header);
  append_chunk(out, "IDAT", compressed(rows));
  append_chunk(out, "IEND", "");
  return out;
}

std::size_t PngImage::offset(int x, int y) const {
  return kChannels * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(x));
}

}  // namespace cornerfix::evaluation

#include "core/src/map/png_map_image.hpp"

#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <new>
#include <string>
#include <utility>
#include <vector>

namespace cornerfix {

namespace {

constexpr std::size_t kPngSignatureBytes = 8;
constexpr std::size_t kRgba = 4;

/// What libpng's callbacks share with the code around them.
struct PngSource {
  std::span<const std::byte> bytes;
  std::size_t at = 0;
  std::array<char, 160> message{};
};

[[noreturn]] void on_png_error(png_structp png, png_const_charp message) {
  auto* source = static_cast<PngSource*>(png_get_error_ptr(png));
  std::strncpy(source->message.data(), message, source->message.size() - 1);
  png_longjmp(png, 1);
}

void on_png_warning(png_structp, png_const_charp) {}

void read_png_bytes(png_structp png, png_bytep out, std::size_t count) {
  auto* source = static_cast<PngSource*>(png_get_io_ptr(png));
  if (count > source->bytes.size() - source->at) png_error(png, "the file ends too early");
  std::memcpy(out, source->bytes.data() + source->at, count);
  source->at += count;
}

/// libpng reports errors by longjmp, which runs no destructor: the functions that call setjmp keep
/// plain values only, what owns memory lives in their caller.
class PngReader {
 public:
  explicit PngReader(std::span<const std::byte> bytes) : source_{bytes, 0, {}} {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source_, on_png_error, on_png_warning);
    if (png_ == nullptr) throw std::bad_alloc();
    info_ = png_create_info_struct(png_);
    if (info_ == nullptr) {
      png_destroy_read_struct(&png_, nullptr, nullptr);
      throw std::bad_alloc();
    }
    png_set_read_fn(png_, &source_, read_png_bytes);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  /// Reads the header and requests 8-bit RGBA for any content of the file.
  bool read_header() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_info(png_, info_);
    png_set_expand(png_);    // Palette to RGB, few bits to 8, a transparent colour to alpha.
    png_set_scale_16(png_);  // Rounds where png_set_strip_16 cuts.
    png_set_gray_to_rgb(png_);
    png_set_add_alpha(png_, 0xff, PNG_FILLER_AFTER);
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  bool read_row(unsigned char* row) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_row(png_, row, nullptr);
    return true;
  }

  [[nodiscard]] std::int64_t width() const { return png_get_image_width(png_, info_); }
  [[nodiscard]] std::int64_t height() const { return png_get_image_height(png_, info_); }
  [[nodiscard]] int passes() const { return passes_; }
  [[nodiscard]] Error error() const {
    return {ErrorCode::kMalformed, "png: " + std::string(source_.message.data()), "image"};
  }

 private:
  PngSource source_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  int passes_ = 1;
};

/// A pixel that is more transparent than not is unknown, but in a raw image.
Cell classify_rgba(const MapYaml& yaml, const unsigned char* pixel) {
  constexpr unsigned char kHalfOpaque = 128;
  if (pixel[3] < kHalfOpaque && yaml.mode != MapYaml::Mode::kRaw) return Cell::kUnknown;
  return classify(yaml, (pixel[0] + pixel[1] + pixel[2]) / 3.0 / 255.0);
}

void append_png_bytes(png_structp png, png_bytep bytes, std::size_t count) {
  auto* out = static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
  const auto* first = reinterpret_cast<const std::byte*>(bytes);
  out->insert(out->end(), first, first + count);
}

void no_flush(png_structp) {}

unsigned char grey_of(Cell cell) {
  switch (cell) {
    case Cell::kOccupied:
      return 0;
    case Cell::kFree:
      return 254;
    case Cell::kUnknown:
      break;
  }
  return 205;
}

}  // namespace

bool is_png(std::span<const std::byte> image) {
  return image.size() >= kPngSignatureBytes &&
         png_sig_cmp(reinterpret_cast<png_const_bytep>(image.data()), 0, kPngSignatureBytes) == 0;
}

Result<OccupancyGrid> parse_png(const MapYaml& yaml, std::span<const std::byte> image,
                                const MapImageLimits& limits) {
  PngReader reader(image);
  if (!reader.read_header()) return reader.error();
  Result<ImageRows> grid = empty_rows(yaml, reader.width(), reader.height(), limits);
  if (!grid) return grid.error();
  if (grid->is_thinned() && reader.passes() > 1) {
    return Error{ErrorCode::kTooLarge, "too large for an interlaced png: save it without", "image"};
  }
  grid->allocate();

  // An interlaced image comes in passes over all of its rows, so all of them are kept.
  const std::size_t stride = static_cast<std::size_t>(grid->width()) * kRgba;
  const std::size_t rows_kept = reader.passes() > 1 ? static_cast<std::size_t>(grid->height()) : 1;
  std::vector<unsigned char> rows(stride * rows_kept);
  for (int pass = 0; pass < reader.passes(); ++pass) {
    for (int row = 0; row < grid->height(); ++row) {
      unsigned char* pixels = rows.data() + stride * (static_cast<std::size_t>(row) % rows_kept);
      if (!reader.read_row(pixels)) return reader.error();
      if (pass + 1 < reader.passes()) continue;
      for (Cell& cell : grid->row(row)) {
        cell = classify_rgba(yaml, pixels);
        pixels += kRgba;
      }
      grid->finish_row(row);
    }
  }
  return std::move(*grid).take();
}

std::vector<std::byte> encode_grid_png(const OccupancyGrid& grid) {
  std::vector<std::byte> out;
  if (grid.width < 1 || grid.height < 1) return out;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, on_png_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  std::vector<unsigned char> row(static_cast<std::size_t>(grid.width));
  if (info != nullptr && setjmp(png_jmpbuf(png)) == 0) {
    png_set_write_fn(png, &out, append_png_bytes, no_flush);
    png_set_IHDR(png, info, static_cast<png_uint_32>(grid.width),
                 static_cast<png_uint_32>(grid.height), 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    for (int i = grid.height - 1; i >= 0; --i) {
      const Cell* cells = grid.cells.data() + grid.offset({0, i});
      std::transform(cells, cells + grid.width, row.begin(), grey_of);
      png_write_row(png, row.data());
    }
    png_write_end(png, nullptr);
  }
  png_destroy_write_struct(&png, &info);
  return out;
}

}  // namespace cornerfix

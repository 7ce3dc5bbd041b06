#include "core/src/map/pgm_image.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cornerfix {

namespace {

Error pgm_error(const std::string& message) {
  return {ErrorCode::kMalformed, "pgm: " + message, "image"};
}

/// Reads the white-space separated numbers of a pgm; a comment runs from # to the end of the line.
class PgmReader {
 public:
  explicit PgmReader(std::string_view text) : text_(text) {}

  /// Nothing at the end, or where no number stands.
  std::optional<std::int64_t> next_number() {
    skip_space_and_comments();
    std::int64_t value = 0;
    const auto [end, error] =
        std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc() || value < 0) return std::nullopt;
    at_ = static_cast<std::size_t>(end - text_.data());
    return value;
  }

  void skip(std::size_t count) { at_ = std::min(at_ + count, text_.size()); }
  [[nodiscard]] bool is_at_end() const { return at_ == text_.size(); }
  [[nodiscard]] std::string_view rest() const { return text_.substr(at_); }

 private:
  void skip_space_and_comments() {
    while (at_ < text_.size()) {
      if (text_[at_] == '#') {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (std::string_view(" \t\r\n\v\f").find(text_[at_]) != std::string_view::npos) {
        ++at_;
      } else {
        return;
      }
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

/// Classes of all grey values, so that a pixel costs one look-up. Fewer values than 256 are scaled
/// to bytes and cut as map_server does. So the grey of unknown cells, 205 of 255, stays below what
/// the default free_thresh takes for free.
std::vector<Cell> classes_of_grey_values(const MapYaml& yaml, std::int64_t max_value) {
  constexpr std::int64_t kByte = 255;
  const std::int64_t scale = std::max(max_value, kByte);
  std::vector<Cell> classes;
  classes.reserve(static_cast<std::size_t>(max_value) + 1);
  for (std::int64_t value = 0; value <= max_value; ++value) {
    const std::int64_t scaled = value * scale / max_value;
    classes.push_back(classify(yaml, static_cast<double>(scaled) / static_cast<double>(scale)));
  }
  return classes;
}

Error pgm_value_above_maximum() { return pgm_error("a value above its maximum"); }

/// P2: the values in decimal.
Result<void> read_plain_pixels(PgmReader& reader, const std::vector<Cell>& classes,
                               ImageRows& rows) {
  // The shortest pixel is a digit and a blank.
  if ((reader.rest().size() + 1) / 2 <
      static_cast<std::size_t>(rows.width()) * static_cast<std::size_t>(rows.height())) {
    return pgm_error("the file ends before the last pixel");
  }
  rows.allocate();
  for (int row = 0; row < rows.height(); ++row) {
    for (Cell& cell : rows.row(row)) {
      const auto value = reader.next_number();
      if (!value && !reader.is_at_end()) {
        return pgm_error("row " + std::to_string(row) + " has a value that is no number");
      }
      if (!value) return pgm_error("the file ends before the last pixel");
      if (static_cast<std::size_t>(*value) >= classes.size()) return pgm_value_above_maximum();
      cell = classes[static_cast<std::size_t>(*value)];
    }
    rows.finish_row(row);
  }
  return {};
}

/// How much of `rest`, which is what follows the maximum value, is in front of the pixels: a single
/// blank. CR and LF, or a comment, where the file is just so much longer.
std::size_t bytes_before_pixels(std::string_view rest, std::size_t pixel_bytes) {
  if (rest.starts_with("\r\n") && rest.size() == pixel_bytes + 2) return 2;
  const std::size_t begin = rest.find_first_not_of(" \t\r\n");
  if (begin < rest.size() && rest[begin] == '#') {
    const std::size_t line_end = rest.find('\n', begin);
    if (line_end < rest.size() && rest.size() == line_end + 1 + pixel_bytes) return line_end + 1;
  }
  return std::min<std::size_t>(rest.size(), 1);
}

/// Whether each LF of the file has become CR and LF, as git and FTP do with texts.
bool has_converted_line_ends(std::string_view rest, std::size_t pixel_bytes) {
  constexpr std::string_view kLineEnd = "\r\n";
  if (!rest.starts_with(kLineEnd)) return false;
  std::size_t line_ends = 0;
  for (std::size_t at = 0; (at = rest.find(kLineEnd, at)) < rest.size(); at += 2) ++line_ends;
  return line_ends > 1 && rest.size() == 1 + pixel_bytes + line_ends;
}

/// P5: a byte per value, or two with the higher first. `pixels` begin with the end of the header.
Result<void> read_binary_pixels(std::string_view pixels, const std::vector<Cell>& classes,
                                ImageRows& rows) {
  const std::size_t bytes_per_value = classes.size() > 256 ? 2 : 1;
  const std::size_t expected = static_cast<std::size_t>(rows.width()) *
                               static_cast<std::size_t>(rows.height()) * bytes_per_value;
  if (has_converted_line_ends(pixels, expected)) {
    return pgm_error("its line feeds have become CR LF: copy it as a binary file");
  }
  pixels.remove_prefix(bytes_before_pixels(pixels, expected));
  if (pixels.size() < expected) {
    return pgm_error(std::to_string(pixels.size()) + " bytes of pixels, expected " +
                     std::to_string(expected));
  }
  rows.allocate();
  const auto* byte = reinterpret_cast<const unsigned char*>(pixels.data());
  for (int row = 0; row < rows.height(); ++row) {
    for (Cell& cell : rows.row(row)) {
      const std::size_t value = bytes_per_value == 2 ? byte[0] * 256U + byte[1] : byte[0];
      if (value >= classes.size()) return pgm_value_above_maximum();
      cell = classes[value];
      byte += bytes_per_value;
    }
    rows.finish_row(row);
  }
  return {};
}

}  // namespace

Result<OccupancyGrid> parse_pgm(const MapYaml& yaml, std::string_view image,
                                const MapImageLimits& limits) {
  const bool plain = image[1] == '2';
  PgmReader reader(image);
  reader.skip(2);
  const auto width = reader.next_number();
  const auto height = reader.next_number();
  const auto max_value = reader.next_number();
  if (!width || !height || !max_value) {
    return pgm_error("expected width, height and maximum value");
  }
  if (*max_value < 1 || *max_value > 65535) {
    return pgm_error("maximum value " + std::to_string(*max_value) + ", expected 1 to 65535");
  }
  Result<ImageRows> rows = empty_rows(yaml, *width, *height, limits);
  if (!rows) return rows.error();
  const std::vector<Cell> classes = classes_of_grey_values(yaml, *max_value);
  const Result<void> read = plain ? read_plain_pixels(reader, classes, *rows)
                                  : read_binary_pixels(reader.rest(), classes, *rows);
  if (!read) return read.error();
  return std::move(*rows).take();
}

}  // namespace cornerfix

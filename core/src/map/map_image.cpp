#include <cornerfix/map_image.hpp>

#include <png.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <fstream>
#include <limits>
#include <new>
#include <optional>

#include "core/src/map/bmp_image.hpp"
#include "core/src/map/image_rows.hpp"

namespace cornerfix {

namespace {

constexpr double kOccupiedThreshold = 0.65;  // map_server's own defaults.
constexpr double kFreeThreshold = 0.196;
constexpr std::uintmax_t kMaxYamlBytes = 1 << 20;

enum class Mode { kTrinary, kScale, kRaw };

/// What the yaml says; the names are map_server's.
struct MapYaml {
  std::string image;
  double resolution = 0.0;
  Pose2 origin;
  bool negate = false;
  double occupied_thresh = kOccupiedThreshold;
  double free_thresh = kFreeThreshold;
  Mode mode = Mode::kTrinary;
};

Error malformed(std::string message, std::string field) {
  return {ErrorCode::kMalformed, std::move(message), std::move(field)};
}

Error invalid(std::string message, std::string field) {
  return {ErrorCode::kInvalidArgument, std::move(message), std::move(field)};
}

// --- yaml ---------------------------------------------------------------------------------------

/// A finite number, or `fallback` where the key is missing.
Result<double> number(const YAML::Node& node, const char* key, std::optional<double> fallback) {
  if (!node) {
    if (fallback) return *fallback;
    return invalid("missing, expected a number", key);
  }
  double value = 0.0;
  if (!YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
    return invalid("expected a finite number", key);
  }
  return value;
}

Result<Pose2> parse_origin(const YAML::Node& node) {
  constexpr const char* kExpected = "expected [x, y, yaw] in metres and radians";
  if (!node || !node.IsSequence() || node.size() != 3) return invalid(kExpected, "origin");
  std::array<double, 3> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Result<double> value = number(node[i], "origin", std::nullopt);
    if (!value) return invalid(kExpected, "origin");
    values[i] = *value;
  }
  if (std::max(std::abs(values[0]), std::abs(values[1])) > kFarthestOrigin)
    return invalid("expected x and y within 1e8 m", "origin");
  return Pose2{values[0], values[1], wrap_angle(values[2])};
}

Result<Mode> parse_mode(const YAML::Node& node) {
  if (!node) return Mode::kTrinary;
  const std::string name = node.IsScalar() ? node.Scalar() : std::string();
  if (name == "trinary") return Mode::kTrinary;
  if (name == "scale") return Mode::kScale;
  if (name == "raw") return Mode::kRaw;
  return invalid("expected trinary, scale or raw", "mode");
}

/// 0 and 1 as map_server takes them, or a truth value of YAML (True, yes, off, ...) as nav2 does.
Result<bool> parse_negate(const YAML::Node& node) {
  if (!node) return false;
  const std::string text = node.IsScalar() ? node.Scalar() : std::string();
  if (text == "0" || text == "1") return text == "1";
  bool value = false;
  if (YAML::convert<bool>::decode(node, value)) return value;
  return invalid("expected 0 or 1, true or false", "negate");
}

Result<MapYaml> parse_map_yaml(const YAML::Node& root) {
  if (!root.IsMap()) return malformed("expected the keys of a map_server yaml", "yaml");
  MapYaml out;
  if (!root["image"] || !root["image"].IsScalar() || root["image"].Scalar().empty()) {
    return invalid("missing, expected the name of a pgm, png or bmp file", "image");
  }
  out.image = root["image"].Scalar();

  const Result<double> resolution = number(root["resolution"], "resolution", std::nullopt);
  if (!resolution) return resolution.error();
  if (*resolution < kFinestCell || *resolution > kCoarsestCell)
    return invalid("expected metres a cell from 0.001 to 100", "resolution");
  out.resolution = *resolution;

  const Result<Pose2> origin = parse_origin(root["origin"]);
  if (!origin) return origin.error();
  out.origin = *origin;

  const Result<bool> negate = parse_negate(root["negate"]);
  if (!negate) return negate.error();
  out.negate = *negate;

  const Result<double> occupied =
      number(root["occupied_thresh"], "occupied_thresh", kOccupiedThreshold);
  if (!occupied) return occupied.error();
  const Result<double> free = number(root["free_thresh"], "free_thresh", kFreeThreshold);
  if (!free) return free.error();
  if (*occupied < 0.0 || *occupied > 1.0) return invalid("expected 0 to 1", "occupied_thresh");
  if (*free < 0.0 || *free > *occupied) {
    return invalid("expected 0 to occupied_thresh", "free_thresh");
  }
  out.occupied_thresh = *occupied;
  out.free_thresh = *free;

  const Result<Mode> mode = parse_mode(root["mode"]);
  if (!mode) return mode.error();
  out.mode = *mode;
  return out;
}

Result<MapYaml> parse_map_yaml(std::string_view yaml) {
  try {
    return parse_map_yaml(YAML::Load(std::string(yaml)));
  } catch (const YAML::Exception& error) {
    return malformed(error.what(), "yaml");
  }
}

// --- cells --------------------------------------------------------------------------------------

/// Whether a cell is a wall, from how bright its pixel is in [0, 1].
Cell classify(const MapYaml& yaml, double brightness) {
  const double shade = yaml.negate ? 1.0 - brightness : brightness;
  // A raw image holds percentages of occupancy; above 100 is unknown.
  const double occupied = yaml.mode == Mode::kRaw ? std::round(shade * 255.0) / 100.0 : 1.0 - shade;
  if (occupied > 1.0) return Cell::kUnknown;
  if (occupied > yaml.occupied_thresh) return Cell::kOccupied;
  if (occupied < yaml.free_thresh) return Cell::kFree;
  return Cell::kUnknown;
}

Result<ImageRows> empty_rows(const MapYaml& yaml, std::int64_t width, std::int64_t height,
                             const MapImageLimits& limits) {
  return ImageRows::create(width, height, yaml.resolution, yaml.origin, limits);
}

// --- pgm ----------------------------------------------------------------------------------------

/// Reads the white-space separated numbers of a pgm; a comment runs from # to the end of the line.
class PgmReader {
 public:
  explicit PgmReader(std::string_view text) : text_(text) {}

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

/// Classes of all grey values, so that a pixel costs one look-up.
std::vector<Cell> classes_of_grey_values(const MapYaml& yaml, std::int64_t max_value) {
  std::vector<Cell> classes;
  classes.reserve(static_cast<std::size_t>(max_value) + 1);
  for (std::int64_t value = 0; value <= max_value; ++value) {
    classes.push_back(classify(yaml, static_cast<double>(value) / static_cast<double>(max_value)));
  }
  return classes;
}

Error pgm_value_above_maximum() { return malformed("pgm: a value above its maximum", "image"); }

/// P2: the values in decimal.
Result<void> read_plain_pixels(PgmReader& reader, const std::vector<Cell>& classes,
                               ImageRows& rows) {
  // The shortest pixel is a digit and a blank.
  if ((reader.rest().size() + 1) / 2 <
      static_cast<std::size_t>(rows.width()) * static_cast<std::size_t>(rows.height())) {
    return malformed("pgm: the file ends before the last pixel", "image");
  }
  rows.allocate();
  for (int row = 0; row < rows.height(); ++row) {
    for (Cell& cell : rows.row(row)) {
      const auto value = reader.next_number();
      if (!value) return malformed("pgm: the file ends before the last pixel", "image");
      if (static_cast<std::size_t>(*value) >= classes.size()) return pgm_value_above_maximum();
      cell = classes[static_cast<std::size_t>(*value)];
    }
    rows.finish_row(row);
  }
  return {};
}

/// P5: a byte a value, or two with the higher first.
Result<void> read_binary_pixels(std::string_view pixels, const std::vector<Cell>& classes,
                                ImageRows& rows) {
  const std::size_t bytes_per_value = classes.size() > 256 ? 2 : 1;
  const std::size_t expected = static_cast<std::size_t>(rows.width()) *
                               static_cast<std::size_t>(rows.height()) * bytes_per_value;
  if (pixels.size() < expected) {
    return malformed("pgm: " + std::to_string(pixels.size()) + " bytes of pixels, expected " +
                         std::to_string(expected),
                     "image");
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

Result<OccupancyGrid> parse_pgm(const MapYaml& yaml, std::string_view image,
                                const MapImageLimits& limits) {
  const bool plain = image[1] == '2';
  PgmReader reader(image);
  reader.skip(2);
  const auto width = reader.next_number();
  const auto height = reader.next_number();
  const auto max_value = reader.next_number();
  if (!width || !height || !max_value) {
    return malformed("pgm: expected width, height and maximum value", "image");
  }
  if (*max_value < 1 || *max_value > 65535) {
    return malformed("pgm: maximum value " + std::to_string(*max_value) + ", expected 1 to 65535",
                     "image");
  }
  Result<ImageRows> rows = empty_rows(yaml, *width, *height, limits);
  if (!rows) return rows.error();
  const std::vector<Cell> classes = classes_of_grey_values(yaml, *max_value);
  if (!plain) reader.skip(1);  // A single blank stands before the pixels.
  const Result<void> read = plain ? read_plain_pixels(reader, classes, *rows)
                                  : read_binary_pixels(reader.rest(), classes, *rows);
  if (!read) return read.error();
  return std::move(*rows).take();
}

// --- bmp ----------------------------------------------------------------------------------------

Result<OccupancyGrid> parse_bmp(const MapYaml& yaml, std::span<const std::byte> image,
                                const MapImageLimits& limits) {
  const Result<BmpImage> bmp = BmpImage::open(image);
  if (!bmp) return bmp.error();
  Result<ImageRows> rows = empty_rows(yaml, bmp->width(), bmp->height(), limits);
  if (!rows) return rows.error();
  rows->allocate();
  for (int row = 0; row < rows->height(); ++row) {
    std::int64_t column = 0;
    for (Cell& cell : rows->row(row)) cell = classify(yaml, bmp->brightness(row, column++));
    rows->finish_row(row);
  }
  return std::move(*rows).take();
}

// --- png ----------------------------------------------------------------------------------------

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
    return malformed("png: " + std::string(source_.message.data()), "image");
  }

 private:
  PngSource source_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  int passes_ = 1;
};

/// A pixel that can be seen through is unknown, but in a raw image.
Cell classify_rgba(const MapYaml& yaml, const unsigned char* pixel) {
  if (pixel[3] != 255 && yaml.mode != Mode::kRaw) return Cell::kUnknown;
  return classify(yaml, (pixel[0] + pixel[1] + pixel[2]) / 3.0 / 255.0);
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

// --- files --------------------------------------------------------------------------------------

Result<std::string> read_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return Error{ErrorCode::kNotFound, error.message(), path.string()};
  if (size > max_bytes) {
    return Error{
        ErrorCode::kTooLarge,
        std::to_string(size) + " bytes, at most " + std::to_string(max_bytes) + " are taken",
        path.string()};
  }
  std::string text(static_cast<std::size_t>(size), '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file.read(text.data(), static_cast<std::streamsize>(text.size()))) {
    return Error{ErrorCode::kUnavailable, "cannot be read", path.string()};
  }
  return text;
}

Result<OccupancyGrid> parse_image(const MapYaml& yaml, std::span<const std::byte> image,
                                  const MapImageLimits& limits) {
  try {
    const std::string_view text(reinterpret_cast<const char*>(image.data()), image.size());
    if (text.starts_with("P2") || text.starts_with("P5")) return parse_pgm(yaml, text, limits);
    if (image.size() >= kPngSignatureBytes &&
        png_sig_cmp(reinterpret_cast<png_const_bytep>(image.data()), 0, kPngSignatureBytes) == 0) {
      return parse_png(yaml, image, limits);
    }
    if (BmpImage::is_bmp(image)) return parse_bmp(yaml, image, limits);
    return malformed("neither a grey pgm (P2, P5), a png nor a bmp", "image");
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kTooLarge, "not enough memory", "image"};
  }
}

/// The shortest text that reads back as the same number.
std::string to_text(double value) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

/// How much of the border of free space, but for that of the image, is wall.
double walled_share(const OccupancyGrid& grid) {
  std::size_t walls = 0;
  std::size_t border = 0;
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      if (grid.at({column, row}) != Cell::kFree) continue;
      for (const CellIndex next : {CellIndex{column + 1, row}, CellIndex{column - 1, row},
                                   CellIndex{column, row + 1}, CellIndex{column, row - 1}}) {
        if (!grid.contains(next) || grid.at(next) == Cell::kFree) continue;
        ++border;
        walls += grid.at(next) == Cell::kOccupied ? 1 : 0;
      }
    }
  }
  return border == 0 ? 1.0 : static_cast<double>(walls) / static_cast<double>(border);
}

struct ImagePath {
  std::filesystem::path path;
  std::string note;
};

/// Where the image of a yaml is: a path of another computer is taken for the file of that name
/// beside the yaml, if there is one.
ImagePath image_beside(const std::filesystem::path& yaml_path, const std::string& image) {
  const std::filesystem::path directory = yaml_path.parent_path();
  std::error_code error;
  std::filesystem::path named = directory / image;
  if (std::filesystem::exists(named, error)) return {std::move(named), ""};
  std::filesystem::path beside = directory / image.substr(image.find_last_of("/\\") + 1);
  if (beside == named || !std::filesystem::is_regular_file(beside, error)) {
    return {std::move(named), ""};
  }
  std::string note = "image: " + image + " is not there, " + beside.string() + " is read instead";
  return {std::move(beside), std::move(note)};
}

std::string percent(double share) { return std::to_string(std::lround(100.0 * share)) + " %"; }

}  // namespace

Result<MapFiles> load_map_files(const std::filesystem::path& yaml_path,
                                const MapImageLimits& limits) {
  Result<std::string> text = read_file(yaml_path, kMaxYamlBytes);
  if (!text) return text.error();
  const Result<MapYaml> yaml = parse_map_yaml(*text);
  if (!yaml) {
    return Error{yaml.error().code, yaml.error().field + ": " + yaml.error().message,
                 yaml_path.string()};
  }
  auto [image_path, note] = image_beside(yaml_path, yaml->image);
  // A plain pgm takes at most six bytes a pixel, beside its header.
  const auto max_bytes = static_cast<std::uintmax_t>(limits.max_cells) * 6 + kMaxYamlBytes;
  Result<std::string> image = read_file(image_path, max_bytes);
  if (!image) return image.error();
  return MapFiles{std::move(*text), std::move(image_path), std::move(*image), std::move(note)};
}

Result<OccupancyGrid> read_map_files(const std::filesystem::path& yaml_path,
                                     const MapImageLimits& limits) {
  const Result<MapFiles> files = load_map_files(yaml_path, limits);
  if (!files) return files.error();
  Result<OccupancyGrid> grid =
      parse_map(files->yaml, std::as_bytes(std::span(files->image)), limits);
  if (!grid) return Error{grid.error().code, grid.error().message, files->image_path.string()};
  return grid;
}

Result<OccupancyGrid> parse_map(std::string_view yaml, std::span<const std::byte> image,
                                const MapImageLimits& limits) {
  const Result<MapYaml> parsed = parse_map_yaml(yaml);
  if (!parsed) return parsed.error();
  return parse_image(*parsed, image, limits);
}

std::optional<std::string> thinning_note(std::string_view yaml, const OccupancyGrid& grid) {
  const Result<MapYaml> parsed = parse_map_yaml(yaml);
  if (!parsed || parsed->resolution == grid.resolution) return std::nullopt;
  return "the image is too large at " + to_text(parsed->resolution) +
         " m per pixel: it was thinned to " + to_text(grid.resolution) + " m per cell";
}

std::optional<std::string> threshold_advice(std::string_view yaml, std::span<const std::byte> image,
                                            const MapImageLimits& limits) {
  constexpr double kFewWalls = 0.2;
  constexpr double kEnoughWalls = 0.5;
  const Result<MapYaml> parsed = parse_map_yaml(yaml);
  if (!parsed) return std::nullopt;
  const Result<OccupancyGrid> grid = parse_image(*parsed, image, limits);
  if (!grid) return std::nullopt;
  const double walled = walled_share(*grid);
  if (walled >= kFewWalls) return std::nullopt;
  std::string advice = "at occupied_thresh " + to_text(parsed->occupied_thresh) + " only " +
                       percent(walled) + " of the border of free space is wall";
  for (const double threshold : {0.5, 0.4, 0.3, 0.2}) {
    MapYaml other = *parsed;
    if (threshold >= other.occupied_thresh) continue;
    other.occupied_thresh = threshold;
    other.free_thresh = std::min(other.free_thresh, threshold);
    const Result<OccupancyGrid> fitting = parse_image(other, image, limits);
    if (!fitting || walled_share(*fitting) < kEnoughWalls) continue;
    return advice + "; occupied_thresh " + to_text(threshold) + " would make it " +
           percent(walled_share(*fitting));
  }
  return advice;
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

std::string encode_grid_yaml(const OccupancyGrid& grid, std::string_view image_name) {
  const Pose2& origin = grid.T_map_grid;
  return "image: " + YAML::Dump(YAML::Node(std::string(image_name))) +
         "\nresolution: " + to_text(grid.resolution) + "\norigin: [" + to_text(origin.x) + ", " +
         to_text(origin.y) + ", " + to_text(origin.yaw) +
         "]\nnegate: 0\noccupied_thresh: " + to_text(kOccupiedThreshold) +
         "\nfree_thresh: " + to_text(kFreeThreshold) + "\nmode: trinary\n";
}

}  // namespace cornerfix

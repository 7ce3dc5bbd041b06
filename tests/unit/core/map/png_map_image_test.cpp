#include "core/src/map/png_map_image.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <string>
#include <vector>

#include <cornerfix/map_image.hpp>

#include "support/image_cells.hpp"

namespace cornerfix {
namespace {

using testing::bytes;
using testing::drawn;

Result<OccupancyGrid> parse_png_image(const std::string& image, const MapImageLimits& limits = {},
                                      MapYaml::Mode mode = MapYaml::Mode::kTrinary) {
  MapYaml yaml;
  yaml.resolution = 0.1;
  yaml.mode = mode;
  return parse_png(yaml, std::as_bytes(std::span(image)), limits);
}

/// A png of the given kind; `rows` holds its raw rows.
std::string make_png(int color_type, int bit_depth, const std::vector<std::string>& rows, int width,
                     bool interlaced = false, const std::vector<png_color>& palette = {}) {
  std::string out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &out,
      [](png_structp p, png_bytep data, std::size_t count) {
        static_cast<std::string*>(png_get_io_ptr(p))
            ->append(reinterpret_cast<const char*>(data), count);
      },
      [](png_structp) {});
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(rows.size()),
               bit_depth, color_type, interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (!palette.empty()) png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
  png_write_info(png, info);
  std::vector<std::string> copies = rows;
  std::vector<png_bytep> pointers;
  for (std::string& row : copies) pointers.push_back(reinterpret_cast<png_bytep>(row.data()));
  png_set_interlace_handling(png);
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return out;
}

TEST(PngMapImage, ReadsEveryKindOfPng) {
  EXPECT_EQ(drawn(parse_png_image(make_png(PNG_COLOR_TYPE_GRAY, 8, {bytes({0, 205, 254})}, 3))),
            "#?.");
  EXPECT_EQ(drawn(parse_png_image(make_png(PNG_COLOR_TYPE_GRAY, 1, {bytes({0b01000000})}, 2))),
            "#.");
  EXPECT_EQ(drawn(parse_png_image(
                make_png(PNG_COLOR_TYPE_GRAY, 16, {bytes({0, 0, 205, 205, 254, 254})}, 3))),
            "#?.");
  EXPECT_EQ(drawn(parse_png_image(
                make_png(PNG_COLOR_TYPE_GRAY_ALPHA, 8, {bytes({0, 255, 254, 255, 254, 0})}, 3))),
            "#.?");
  EXPECT_EQ(drawn(parse_png_image(make_png(PNG_COLOR_TYPE_RGB, 8,
                                           {bytes({0, 0, 0, 254, 254, 254, 205, 205, 205})}, 3))),
            "#.?");
  EXPECT_EQ(drawn(parse_png_image(make_png(PNG_COLOR_TYPE_PALETTE, 8, {bytes({1, 0})}, 2, false,
                                           {{255, 255, 255}, {0, 0, 0}}))),
            "#.");
}

TEST(PngMapImage, TakesAPixelForUnknownThatIsMoreTransparentThanNot) {
  EXPECT_EQ(drawn(parse_png_image(
                make_png(PNG_COLOR_TYPE_GRAY_ALPHA, 8, {bytes({0, 254, 254, 128, 254, 127})}, 3))),
            "#.?");
}

TEST(PngMapImage, ReadsAnInterlacedPng) {
  std::vector<std::string> rows;
  for (int row = 0; row < 9; ++row) {
    std::string pixels(9, static_cast<char>(254));
    pixels[static_cast<std::size_t>(row)] = 0;
    rows.push_back(pixels);
  }
  const auto grid = parse_png_image(make_png(PNG_COLOR_TYPE_GRAY, 8, rows, 9, true));
  ASSERT_TRUE(grid.ok()) << grid.error().message;
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column) {
      EXPECT_EQ(grid->at({column, 8 - row}), row == column ? Cell::kOccupied : Cell::kFree);
    }
  }
}

TEST(PngMapImage, SurvivesEveryCutOfAPng) {
  std::string row(40, static_cast<char>(254));
  for (std::size_t i = 0; i < row.size(); ++i) row[i] = static_cast<char>(i * 37);
  const std::string png = make_png(PNG_COLOR_TYPE_GRAY, 8, {row, row, row}, 40);
  for (std::size_t size = 0; size + 16 < png.size(); ++size) {
    EXPECT_FALSE(parse_png_image(png.substr(0, size)).ok()) << size;
  }
}

TEST(PngMapImage, IgnoresTransparencyInARawImage) {
  const std::string clear = make_png(PNG_COLOR_TYPE_GRAY_ALPHA, 8, {bytes({0, 0})}, 1);
  EXPECT_EQ(drawn(parse_png_image(clear)), "?");
  EXPECT_EQ(drawn(parse_png_image(clear, {}, MapYaml::Mode::kRaw)), ".");
}

TEST(PngMapImage, RefusesASizeAboveTheLimit) {
  const std::string png = make_png(PNG_COLOR_TYPE_GRAY, 8, {bytes({0, 0}), bytes({0, 0})}, 2);
  EXPECT_TRUE(parse_png_image(png, {.max_cells = 4}));
  EXPECT_EQ(parse_png_image(png, {.max_cells = 3}).error().code, ErrorCode::kTooLarge);
}

TEST(PngMapImage, WritesTheColoursOfMapServerWithTheHighestRowFirst) {
  OccupancyGrid grid;
  grid.width = 1;
  grid.height = 3;
  grid.cells = {Cell::kOccupied, Cell::kFree, Cell::kUnknown};
  const std::vector<std::byte> png = encode_grid_png(grid);
  ASSERT_TRUE(is_png(png));
  const std::string file(reinterpret_cast<const char*>(png.data()), png.size());
  EXPECT_EQ(drawn(parse_png_image(file)), "?/./#");
}

TEST(PngMapImage, WritesNothingForAGridWithoutCells) { EXPECT_TRUE(encode_grid_png({}).empty()); }

TEST(PngMapImage, IsKnownByItsFirstBytes) {
  const std::string other = "P5\n1 1\n255\n";
  EXPECT_FALSE(is_png(std::as_bytes(std::span(other))));
  EXPECT_FALSE(is_png({}));
}

}  // namespace
}  // namespace cornerfix

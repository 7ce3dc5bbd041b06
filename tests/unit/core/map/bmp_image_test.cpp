#include "core/src/map/bmp_image.hpp"

#include <gtest/gtest.h>

#include <string>

namespace cornerfix {
namespace {

std::string little_endian(std::uint32_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>(value >> (8 * i)));
  return out;
}

/// A bitmap without compression. `pixels` holds its padded rows.
std::string make_bmp(int width, int height, int bits, const std::string& palette,
                     const std::string& pixels) {
  const auto colours = static_cast<std::uint32_t>(palette.size() / 4);
  const auto pixels_at = static_cast<std::uint32_t>(54 + palette.size());
  return "BM" + little_endian(pixels_at + static_cast<std::uint32_t>(pixels.size()), 4) +
         little_endian(0, 4) + little_endian(pixels_at, 4) + little_endian(40, 4) +
         little_endian(static_cast<std::uint32_t>(width), 4) +
         little_endian(static_cast<std::uint32_t>(height), 4) + little_endian(1, 2) +
         little_endian(static_cast<std::uint32_t>(bits), 2) + little_endian(0, 16) +
         little_endian(colours, 4) + little_endian(0, 4) + palette + pixels;
}

std::span<const std::byte> bytes_of(const std::string& file) {
  return std::as_bytes(std::span(file));
}

const std::string kBlackWhite("\0\0\0\0\xFF\xFF\xFF\0", 8);

TEST(BmpImage, PutsTheFirstStoredRowAtTheBottom) {
  const std::string file = make_bmp(1, 2, 24, "", std::string("\xFF\xFF\xFF\0\0\0\0\0", 8));
  const Result<BmpImage> image = BmpImage::open(bytes_of(file));
  ASSERT_TRUE(image);
  EXPECT_EQ(image->brightness(0, 0), 0.0);
  EXPECT_EQ(image->brightness(1, 0), 1.0);
}

TEST(BmpImage, PutsTheFirstStoredRowAtTheTopWhenTheHeightIsNegative) {
  const std::string file = make_bmp(1, -2, 24, "", std::string("\xFF\xFF\xFF\0\0\0\0\0", 8));
  const Result<BmpImage> image = BmpImage::open(bytes_of(file));
  ASSERT_TRUE(image);
  EXPECT_EQ(image->height(), 2);
  EXPECT_EQ(image->brightness(0, 0), 1.0);
}

TEST(BmpImage, ReadsTheFirstPixelOfAByteFromItsHighestBit) {
  const std::string file = make_bmp(3, 1, 1, kBlackWhite, std::string("\xA0\0\0\0", 4));
  const Result<BmpImage> image = BmpImage::open(bytes_of(file));
  ASSERT_TRUE(image);
  EXPECT_EQ(image->width(), 3);
  EXPECT_EQ(image->brightness(0, 0), 1.0);
  EXPECT_EQ(image->brightness(0, 1), 0.0);
  EXPECT_EQ(image->brightness(0, 2), 1.0);
}

TEST(BmpImage, RefusesAFileThatEndsBeforeTheLastPixel) {
  const std::string file = make_bmp(1, 2, 24, "", std::string("\0\0\0\0", 4));
  const Result<BmpImage> image = BmpImage::open(bytes_of(file));
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().field, "image");
  EXPECT_NE(image.error().message.find("before the last pixel"), std::string::npos);
}

TEST(BmpImage, RefusesBitsPerPixelThatItDoesNotKnow) {
  const std::string file = make_bmp(1, 1, 16, "", std::string("\0\0\0\0", 4));
  ASSERT_FALSE(BmpImage::open(bytes_of(file)));
}

TEST(BmpImage, KnowsOtherFilesByTheirFirstBytes) {
  EXPECT_FALSE(BmpImage::is_bmp(bytes_of("P5\n1 1\n255\n")));
  EXPECT_FALSE(BmpImage::is_bmp(bytes_of("BM")));
}

}  // namespace
}  // namespace cornerfix

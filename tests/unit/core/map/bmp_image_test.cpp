#include "core/src/map/bmp_image.hpp"

#include <gtest/gtest.h>

#include <string>

#include "support/bitmap.hpp"

namespace cornerfix {
namespace {

using testing::make_bmp;

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

/// Those of red, green and blue, where the palette is in other files.
std::string masks(std::uint32_t red, std::uint32_t green, std::uint32_t blue) {
  return testing::little_endian(red, 4) + testing::little_endian(green, 4) +
         testing::little_endian(blue, 4);
}

constexpr std::uint32_t kBitFields = 3;

TEST(BmpImage, PassesOverTheAlphaWhereverTheMasksPutIt) {
  const std::string behind =
      make_bmp(1, 1, 32, masks(0xff0000, 0xff00, 0xff), std::string("\0\0\0\xFF", 4), kBitFields);
  ASSERT_TRUE(BmpImage::open(bytes_of(behind)));
  EXPECT_EQ(BmpImage::open(bytes_of(behind))->brightness(0, 0), 0.0);
  const std::string in_front = make_bmp(1, 1, 32, masks(0xff000000, 0xff0000, 0xff00),
                                        std::string("\xFF\0\0\0", 4), kBitFields);
  ASSERT_TRUE(BmpImage::open(bytes_of(in_front)));
  EXPECT_EQ(BmpImage::open(bytes_of(in_front))->brightness(0, 0), 0.0);
}

TEST(BmpImage, RefusesMasksThatAreNoBytes) {
  for (const std::string& other : {masks(0x3ff00000, 0xffc00, 0x3ff), masks(0xff, 0xff, 0xff),
                                   masks(0xff000000, 0xff00, 0xff), masks(0, 0, 0)}) {
    const std::string file = make_bmp(1, 1, 32, other, std::string("\0\0\0\0", 4), kBitFields);
    ASSERT_FALSE(BmpImage::open(bytes_of(file)));
  }
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

#include "evaluation/metrics/png_image.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <string>

namespace cornerfix::evaluation {
namespace {

std::size_t number_at(const std::string& bytes, std::size_t begin) {
  std::size_t number = 0;
  for (std::size_t i = begin; i < begin + 4; ++i)
    number = number << 8U | static_cast<unsigned char>(bytes[i]);
  return number;
}

/// Data of the chunk that begins at `begin`; checks its checksum.
std::string chunk(const std::string& png, std::size_t begin, const std::string& type) {
  const std::size_t size = number_at(png, begin);
  EXPECT_EQ(png.substr(begin + 4, 4), type);
  const std::string body = png.substr(begin + 4, size + 4);
  EXPECT_EQ(number_at(png, begin + 8 + size),
            crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size())));
  return body.substr(4);
}

TEST(PngImage, IsAWholePngFileOfItsPixels) {
  PngImage image(3, 2, {1, 2, 3});
  image.set(2, 1, {200, 100, 50});
  image.set(3, 0, {9, 9, 9});
  image.set(0, -1, {9, 9, 9});
  EXPECT_EQ(image.at(2, 1), (Rgb{200, 100, 50}));
  const std::string png = image.encode();
  EXPECT_EQ(png.substr(0, 8), std::string("\x89PNG\r\n\x1a\n"));
  const std::string header = chunk(png, 8, "IHDR");
  EXPECT_EQ(number_at(header, 0), 3U);
  EXPECT_EQ(number_at(header, 4), 2U);
  const std::string data = chunk(png, 8 + 12 + header.size(), "IDAT");
  std::string rows(2 * (1 + 3 * 3), '\0');
  uLongf size = rows.size();
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(rows.data()), &size,
                       reinterpret_cast<const Bytef*>(data.data()), data.size()),
            Z_OK);
  const std::string background("\x01\x02\x03");
  const std::string row = std::string(1, '\0') + background + background;
  EXPECT_EQ(rows, row + background + row + "\xc8\x64\x32");
}

}  // namespace
}  // namespace cornerfix::evaluation

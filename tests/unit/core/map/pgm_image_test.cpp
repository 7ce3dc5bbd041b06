#include "core/src/map/pgm_image.hpp"

#include <gtest/gtest.h>

#include <string>

#include "support/image_cells.hpp"

namespace cornerfix {
namespace {

using testing::bytes;
using testing::drawn;

Result<OccupancyGrid> parse_pgm_image(const std::string& image, const MapImageLimits& limits = {}) {
  MapYaml yaml;
  yaml.resolution = 0.1;
  return parse_pgm(yaml, image, limits);
}

TEST(PgmImage, ReadsAPlainPgmWithComments) {
  EXPECT_EQ(drawn(parse_pgm_image("P2 # by hand\n# size\n3 1\n# maximum\n100\n0 100\t80\n")),
            "#.?");
}

TEST(PgmImage, ReadsSixteenBitValuesHighByteFirst) {
  EXPECT_EQ(drawn(parse_pgm_image("P5\n2 1\n65535\n" + bytes({0x00, 0xff, 0xff, 0x00}))), "#.");
}

TEST(PgmImage, TakesAHeaderWhoseLinesEndAsOnWindows) {
  const std::string header = "P5\r\n3 1\r\n255\r\n";
  EXPECT_EQ(drawn(parse_pgm_image(header + bytes({0, 255, 0}))), "#.#");
  EXPECT_EQ(drawn(parse_pgm_image("P5\n3 1\n255\r\n" + bytes({255, 0}))), "#.#")
      << "where nothing is left over, the line feed is a pixel";
}

TEST(PgmImage, PassesOverACommentBehindTheMaximumValue) {
  EXPECT_EQ(drawn(parse_pgm_image("P5\n3 1\n255\n# by hand\n" + bytes({0, 255, 0}))), "#.#");
  EXPECT_EQ(drawn(parse_pgm_image("P5\n3 1\n255 # by hand\n" + bytes({0, 255, 0}))), "#.#");
  EXPECT_EQ(drawn(parse_pgm_image("P5\n3 1\n255\n" + bytes({'#', 255, '\n'}))), "#.#")
      << "where nothing is left over, # is a pixel";
}

TEST(PgmImage, RefusesAPgmWhoseLineFeedsWereConverted) {
  const auto grid = parse_pgm_image("P5\r\n3 1\r\n255\r\n" + bytes({0, '\r', '\n', 255}));
  ASSERT_FALSE(grid.ok());
  EXPECT_EQ(grid.error().message,
            "pgm: its line feeds have become CR LF: copy it as a binary file");
}

TEST(PgmImage, ScalesFewGreyValuesAsMapServerDoes) {
  // 205 of 255, the grey of unknown cells, to the nearest.
  EXPECT_EQ(drawn(parse_pgm_image("P5\n3 1\n200\n" + bytes({0, 161, 200}))), "#?.");
  EXPECT_EQ(drawn(parse_pgm_image("P2\n3 1\n254\n0 205 254\n")), "#?.");
}

TEST(PgmImage, JudgesAValueByTheMaximumOfTheFile) {
  EXPECT_EQ(drawn(parse_pgm_image("P5\n3 1\n10\n" + bytes({0, 8, 10}))), "#?.");
}

TEST(PgmImage, StatesHowManyBytesOfPixelsAreMissing) {
  const auto grid = parse_pgm_image("P5\n2 2\n255\n...");
  ASSERT_FALSE(grid);
  EXPECT_EQ(grid.error().field, "image");
  EXPECT_EQ(grid.error().message, "pgm: 3 bytes of pixels, expected 4");
}

TEST(PgmImage, NamesTheRowOfAValueThatIsNoNumber) {
  EXPECT_EQ(drawn(parse_pgm_image("P2\n1 3\n255\n7\nx 999")),
            "image: pgm: row 1 has a value that is no number");
}

TEST(PgmImage, RefusesAValueAboveTheMaximum) {
  for (const char* image : {"P2\n1 1\n99\n100", "P5\n1 1\n99\nd"})
    EXPECT_EQ(drawn(parse_pgm_image(image)), "image: pgm: a value above its maximum");
}

TEST(PgmImage, RefusesASizeAboveTheLimit) {
  const std::string image = "P5\n2 2\n255\n" + bytes({0, 0, 0, 0});
  EXPECT_TRUE(parse_pgm_image(image, {.max_cells = 4}));
  EXPECT_EQ(parse_pgm_image(image, {.max_cells = 3}).error().code, ErrorCode::kTooLarge);
}

TEST(PgmImage, IsKnownByItsFirstBytes) {
  EXPECT_TRUE(is_pgm("P2\n"));
  EXPECT_TRUE(is_pgm("P5\n"));
  EXPECT_FALSE(is_pgm("P6\n"));
  EXPECT_FALSE(is_pgm("P"));
}

}  // namespace
}  // namespace cornerfix

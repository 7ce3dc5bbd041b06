#include "core/src/map/map_yaml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace cornerfix {
namespace {

using ::testing::HasSubstr;

constexpr const char* kLeast = "image: a.pgm\nresolution: 0.05\norigin: [1, 2, 0.5]\n";

TEST(MapYaml, HasTheDefaultsOfMapServer) {
  const auto yaml = parse_map_yaml(kLeast);
  ASSERT_TRUE(yaml.ok()) << yaml.error().message;
  EXPECT_EQ(yaml->image, "a.pgm");
  EXPECT_EQ(yaml->resolution, 0.05);
  EXPECT_EQ(yaml->origin, (Pose2{1.0, 2.0, 0.5}));
  EXPECT_FALSE(yaml->negate);
  EXPECT_EQ(yaml->occupied_thresh, 0.65);
  EXPECT_EQ(yaml->free_thresh, 0.196);
  EXPECT_EQ(yaml->mode, MapYaml::Mode::kTrinary);
}

TEST(MapYaml, TakesModesInAnyCaseAndNone) {
  for (const char* mode : {"scale", "Scale", "SCALE"}) {
    const auto yaml = parse_map_yaml(kLeast + ("mode: " + std::string(mode) + "\n"));
    ASSERT_TRUE(yaml.ok()) << mode;
    EXPECT_EQ(yaml->mode, MapYaml::Mode::kScale) << mode;
  }
  const auto none = parse_map_yaml(kLeast + std::string("mode:\n"));
  ASSERT_TRUE(none.ok()) << none.error().message;
  EXPECT_EQ(none->mode, MapYaml::Mode::kTrinary);
}

TEST(MapYaml, PassesOverZerosAtTheEnd) {
  EXPECT_TRUE(parse_map_yaml(kLeast + std::string(512, '\0')).ok());
}

TEST(MapYaml, ReadsFilesOfOtherEditors) {
  const std::string text = kLeast;
  std::string crlf;
  for (const char c : text) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  for (const std::string& yaml :
       {"\xef\xbb\xbf" + text, crlf, "---\n" + text + "...\n", text + "extra: [1, 2]\n"}) {
    const auto parsed = parse_map_yaml(yaml);
    ASSERT_TRUE(parsed.ok()) << parsed.error().message;
    EXPECT_EQ(parsed->image, "a.pgm");
  }
}

TEST(MapYaml, TakesAKeyWithoutValueAsMissing) {
  const auto yaml = parse_map_yaml(kLeast + std::string("negate:\noccupied_thresh: ~\n"));
  ASSERT_TRUE(yaml.ok()) << yaml.error().message;
  EXPECT_FALSE(yaml->negate);
  EXPECT_EQ(yaml->occupied_thresh, 0.65);
}

TEST(MapYaml, StatesWhatIsThereInsteadOfWhatWasExpected) {
  const auto message = [](const std::string& lines) {
    const auto yaml = parse_map_yaml("image: a.pgm\n" + lines);
    return yaml.ok() ? "" : yaml.error().field + ": " + yaml.error().message;
  };
  const std::string origin = "origin: [0, 0, 0]\n";
  EXPECT_EQ(message(origin), "resolution: missing, expected a number");
  EXPECT_EQ(message("resolution: 0,05\n" + origin),
            "resolution: expected a finite number, not 0,05");
  EXPECT_EQ(message("resolution: 0.05\norigin: [0, 0]\n"),
            "origin: expected [x, y, yaw] in metres and radians, not [0, 0]");
  EXPECT_EQ(message("resolution: 0.05\n" + origin + "negate: maybe\n"),
            "negate: expected 0 or 1, true or false, not maybe");
  EXPECT_EQ(message("resolution: 0.05\n" + origin + "mode: " + std::string(100, 'x') + "\n"),
            "mode: expected trinary, scale or raw, not " + std::string(60, 'x') + "...");
}

TEST(MapYaml, RefusesAKeyThatIsThereTwice) {
  const auto yaml = parse_map_yaml(kLeast + std::string("resolution: 0.1\n"));
  ASSERT_FALSE(yaml.ok());
  EXPECT_EQ(yaml.error().field, "resolution");
  EXPECT_EQ(yaml.error().message, "there twice, expected once");
}

TEST(MapYaml, KeepsTheDefaultThresholdOfFreeCellsBelowThatOfWalls) {
  const auto yaml = parse_map_yaml(kLeast + std::string("occupied_thresh: 0.1\n"));
  ASSERT_TRUE(yaml.ok()) << yaml.error().message;
  EXPECT_EQ(yaml->free_thresh, 0.1);
}

TEST(MapYaml, NamesAThresholdInPercent) {
  const auto yaml = parse_map_yaml(kLeast + std::string("occupied_thresh: 65\n"));
  ASSERT_FALSE(yaml.ok());
  EXPECT_EQ(yaml.error().field, "occupied_thresh");
  EXPECT_EQ(yaml.error().message, "expected a share from 0 to 1, not 65");
}

TEST(MapYaml, NamesAYawInDegrees) {
  const auto yaml = parse_map_yaml("image: a.pgm\nresolution: 0.05\norigin: [0, 0, 90]\n");
  ASSERT_FALSE(yaml.ok());
  EXPECT_EQ(yaml.error().message,
            "expected a yaw in radians, within a turn (are these degrees?), not [0, 0, 90]");
}

TEST(MapYaml, NamesThresholdsThatAreSwapped) {
  const auto yaml =
      parse_map_yaml(kLeast + std::string("occupied_thresh: 0.2\nfree_thresh: 0.65\n"));
  ASSERT_FALSE(yaml.ok());
  EXPECT_EQ(yaml.error().message,
            "expected a share from 0 to occupied_thresh (0.2, are the two swapped?), not 0.65");
}

TEST(MapYaml, NamesAnImageInThePlaceOfTheYaml) {
  for (const char* image : {"P5\n2 1\n255\n", "\x89PNG\r\n", "BM  "}) {
    const auto yaml = parse_map_yaml(image);
    ASSERT_FALSE(yaml.ok());
    EXPECT_EQ(yaml.error().message, "is an image, expected the yaml: are the two files swapped?");
  }
}

}  // namespace
}  // namespace cornerfix

#include <cornerfix/map_image.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "support/bitmap.hpp"
#include "support/image_cells.hpp"

namespace cornerfix {
namespace {

using testing::bytes;
using testing::drawn;

constexpr const char* kYaml = "image: map.pgm\nresolution: 0.1\norigin: [1.0, 2.0, 0.5]\n";

Result<OccupancyGrid> parse(const std::string& yaml, const std::string& image,
                            const MapImageLimits& limits = {}) {
  return parse_map(yaml, std::as_bytes(std::span(image)), limits);
}

TEST(MapImage, PutsTheFirstImageRowAtTheHighestY) {
  const auto grid = parse(kYaml, "P5\n2 2\n255\n" + bytes({0, 254, 205, 0}));
  ASSERT_TRUE(grid.ok()) << grid.error().message;
  EXPECT_EQ(grid->at({0, 1}), Cell::kOccupied);
  EXPECT_EQ(grid->at({1, 1}), Cell::kFree);
  EXPECT_EQ(grid->at({0, 0}), Cell::kUnknown);
  EXPECT_EQ(grid->at({1, 0}), Cell::kOccupied);
}

TEST(MapImage, TakesResolutionAndOriginWithItsYaw) {
  const auto grid = parse(kYaml, "P5\n1 1\n255\n" + bytes({0}));
  ASSERT_TRUE(grid.ok());
  EXPECT_EQ(grid->resolution, 0.1);
  EXPECT_EQ(grid->T_map_grid, (Pose2{1.0, 2.0, 0.5}));
}

TEST(MapImage, NegateTurnsBlackIntoFree) {
  EXPECT_EQ(drawn(parse(std::string(kYaml) + "negate: 1\n", "P5\n2 1\n255\n" + bytes({0, 255}))),
            ".#");
}

TEST(MapImage, TakesTheTruthValuesOfYamlForNegate) {
  const std::string image = "P5\n2 1\n255\n" + bytes({0, 255});
  for (const char* yes : {"1", "1.0", "'1'", "true", "True", "TRUE", "yes", "Yes", "on"}) {
    EXPECT_EQ(drawn(parse(std::string(kYaml) + "negate: " + yes + "\n", image)), ".#") << yes;
  }
  for (const char* no : {"0", "0.0", "false", "False", "FALSE", "no", "No", "off", "~", ""}) {
    EXPECT_EQ(drawn(parse(std::string(kYaml) + "negate: " + no + "\n", image)), "#.") << no;
  }
}

using testing::make_bmp;

TEST(MapImage, ReadsEveryKindOfBmp) {
  const std::string black_white = bytes({0, 0, 0, 0, 255, 255, 255, 0});
  // Free, wall in the upper row; unknown, free in the lower one.
  const std::string grey = black_white + bytes({205, 205, 205, 0});
  EXPECT_EQ(drawn(parse(kYaml, make_bmp(2, 2, 8, grey, bytes({2, 1, 0, 0, 1, 0, 0, 0})))), ".#/?.");
  EXPECT_EQ(drawn(parse(kYaml, make_bmp(2, -2, 8, grey, bytes({1, 0, 0, 0, 2, 1, 0, 0})))),
            ".#/?.");
  EXPECT_EQ(drawn(parse(kYaml, make_bmp(3, 1, 4, grey, bytes({0x10, 0x20, 0, 0})))), ".#?");
  EXPECT_EQ(drawn(parse(kYaml, make_bmp(3, 1, 1, black_white, bytes({0xa0, 0, 0, 0})))), ".#.");
  EXPECT_EQ(drawn(parse(kYaml, make_bmp(2, 1, 24, "", bytes({255, 255, 255, 0, 0, 0, 0, 0})))),
            ".#");
  EXPECT_EQ(drawn(parse(kYaml, make_bmp(2, 1, 32, "", bytes({255, 255, 255, 0, 0, 0, 0, 255})))),
            ".#");
}

TEST(MapImage, SurvivesEveryCutOfABmp) {
  const std::string bmp =
      make_bmp(2, 2, 8, bytes({0, 0, 0, 0, 255, 255, 255, 0}), bytes({0, 1, 0, 0, 1, 0, 0, 0}));
  for (std::size_t size = 0; size < bmp.size(); ++size) {
    EXPECT_FALSE(parse(kYaml, bmp.substr(0, size)).ok()) << size;
  }
  for (const auto& broken :
       {make_bmp(2, 1, 16, "", std::string(8, '\0')), make_bmp(0, 1, 24, "", ""),
        make_bmp(2, 1, 8, bytes({0, 0, 0, 0}), std::string(4, '\0'), 1),
        make_bmp(0x7fffffff, 0x7fffffff, 32, "", "")}) {
    EXPECT_EQ(parse(kYaml, broken).error().code, ErrorCode::kMalformed);
  }
}

TEST(MapImage, ThinsAFineImageAboveTheLimit) {
  const std::string yaml = "image: a.pgm\nresolution: 0.02\norigin: [1, 2, 0]\n";
  // The middles of five pixels lie in cells 0, 0, 1, 1, 1.
  const std::string image = "P5\n5 3\n255\n" + bytes({254, 254, 205, 205, 205, 254, 254, 254, 205,
                                                      0, 205, 205, 254, 254, 254});
  const auto whole = parse(yaml, image, {.max_cells = 15});
  ASSERT_TRUE(whole.ok());
  EXPECT_EQ(whole->resolution, 0.02);
  EXPECT_FALSE(thinning_note(yaml, *whole));
  const auto grid = parse(yaml, image, {.max_cells = 14});
  ASSERT_TRUE(grid.ok()) << grid.error().message;
  EXPECT_EQ(grid->resolution, 0.05);
  EXPECT_EQ(grid->T_map_grid, (Pose2{1.0, 2.0, 0.0}));
  EXPECT_EQ(drawn(*grid), ".?/.#");
  EXPECT_EQ(thinning_note(yaml, *grid),
            "the image is too large at 0.02 m per pixel: it was thinned to 0.05 m per cell");
}

TEST(MapImage, SaysWhichResolutionFits) {
  const auto coarse = parse(kYaml, "P5\n300 200\n255\n", {.max_cells = 10000});
  EXPECT_EQ(coarse.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(coarse.error().message,
            "300 x 200 pixels of 0.1 m, at most 10000 are taken: save the map with a resolution of "
            "0.25 m or coarser, or cut it");
  const std::string fine = "image: a.pgm\nresolution: 0.04\norigin: [1, 2, 0]\n";
  EXPECT_EQ(parse(fine, "P5\n300 200\n255\n", {.max_cells = 10000}).error().code,
            ErrorCode::kTooLarge);
}

TEST(MapImage, AppliesTheThresholdsOfTheYaml) {
  const std::string image = "P5\n3 1\n100\n" + bytes({60, 50, 40});  // Occupied by 0.4, 0.5, 0.6.
  EXPECT_EQ(drawn(parse(kYaml, image)), "???");
  EXPECT_EQ(drawn(parse(std::string(kYaml) + "occupied_thresh: 0.55\nfree_thresh: 0.45\n", image)),
            ".?#");
}

TEST(MapImage, ReadsRawPercentages) {
  EXPECT_EQ(
      drawn(parse(std::string(kYaml) + "mode: raw\n", "P5\n4 1\n255\n" + bytes({0, 100, 50, 255}))),
      ".#??");
}

TEST(MapImage, ReadsScaleByItsThresholds) {
  EXPECT_EQ(
      drawn(parse(std::string(kYaml) + "mode: scale\n", "P5\n3 1\n255\n" + bytes({0, 128, 255}))),
      "#?.");
}

TEST(MapImage, RefusesWhatIsBroken) {
  const std::string image = "P5\n1 1\n255\n" + bytes({0});
  const std::vector<std::pair<std::string, std::string>> yaml_and_field = {
      {"]", "yaml"},
      {"- a list", "yaml"},
      {"resolution: 0.1\norigin: [0, 0, 0]\n", "image"},
      {"image: a\norigin: [0, 0, 0]\n", "resolution"},
      {"image: a\nresolution: 0\norigin: [0, 0, 0]\n", "resolution"},
      {"image: a\nresolution: .nan\norigin: [0, 0, 0]\n", "resolution"},
      {"image: a\nresolution: 1e-9\norigin: [0, 0, 0]\n", "resolution"},
      {"image: a\nresolution: 1e9\norigin: [0, 0, 0]\n", "resolution"},
      {"image: a\nresolution: 1e307\norigin: [0, 0, 0]\n", "resolution"},
      {"image: a\nresolution: 0.1\norigin: [1.7e308, 0, 0]\n", "origin"},
      {"image: a\nresolution: 0.1\norigin: [0, -2e8, 0]\n", "origin"},
      {"image: a\nresolution: 0.1\n", "origin"},
      {"image: a\nresolution: 0.1\norigin: [0, 0]\n", "origin"},
      {"image: a\nresolution: 0.1\norigin: [0, 0, east]\n", "origin"},
      {std::string(kYaml) + "negate: maybe\n", "negate"},
      {std::string(kYaml) + "occupied_thresh: 1.5\n", "occupied_thresh"},
      {std::string(kYaml) + "free_thresh: 0.9\n", "free_thresh"},
      {std::string(kYaml) + "mode: colourful\n", "mode"},
  };
  for (const auto& [yaml, field] : yaml_and_field) {
    const auto grid = parse(yaml, image);
    ASSERT_FALSE(grid.ok()) << yaml;
    EXPECT_EQ(grid.error().field, field) << yaml;
  }
  for (const char* broken :
       {"", "P", "P5", "P6\n1 1\n255\n...", "P5\n1 1\n0\n.", "P5\n1 1\n70000\n..",
        "P5\n-1 1\n255\n.", "P5\n0 4\n255\n", "P5\n2 2\n255\n...", "P5\n1 1\n10\n\x0b",
        "P2\n2 1\n255\n7", "P2\n2 1\n255\n7 x", "P2\n1 1\n255\n256", "\x89PNG\r\n\x1a\n",
        "GIF89a"}) {
    const auto grid = parse(kYaml, broken);
    ASSERT_FALSE(grid.ok()) << broken;
    EXPECT_EQ(grid.error().code, ErrorCode::kMalformed) << broken;
    EXPECT_FALSE(grid.error().message.empty());
  }
}

TEST(MapImage, NamesAnImageOfAnotherKind) {
  const std::vector<std::pair<std::string, std::string>> image_and_kind = {
      {"P6\n1 1\n255\n...", "a ppm in colour"},
      {"P4\n1 1\n.", "a pbm"},
      {std::string("II*\0", 4), "a tiff"},
      {"\xff\xd8\xff\xe0", "a jpeg"},
      {"GIF89a", "a gif"},
      {"", "empty"},
      {"\x1f\x8b\x08", "packed with gzip"},
      {"image: map.pgm\n", "a yaml"},
      {"version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer"},
      {"anything", "no image that is known"},
  };
  for (const auto& [image, kind] : image_and_kind) {
    const auto grid = parse(kYaml, image);
    ASSERT_FALSE(grid.ok()) << kind;
    EXPECT_NE(grid.error().message.find(kind), std::string::npos) << grid.error().message;
    EXPECT_NE(grid.error().message.find("expected a grey pgm"), std::string::npos);
  }
}

TEST(MapImage, RefusesASizeAboveItsLimitByTheHeaderAlone) {
  for (const char* header : {"P5\n100000 100000\n255\n", "P2\n9000000000 1\n255\n"}) {
    const auto grid = parse(kYaml, header);
    ASSERT_FALSE(grid.ok());
    EXPECT_EQ(grid.error().code, ErrorCode::kTooLarge) << grid.error().message;
  }
}

OccupancyGrid small_grid() {
  OccupancyGrid grid;
  grid.resolution = 0.0504;
  grid.T_map_grid = {-1.25, 1.0 / 3.0, 3.14};
  grid.width = 3;
  grid.height = 2;
  grid.cells = {Cell::kFree,    Cell::kOccupied, Cell::kUnknown,
                Cell::kUnknown, Cell::kFree,     Cell::kOccupied};
  return grid;
}

TEST(MapImage, ReadsBackWhatItWrote) {
  const OccupancyGrid grid = small_grid();
  const auto again = parse_map(encode_grid_yaml(grid, "a map: 1.png"), encode_grid_png(grid));
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(*again, grid);
}

class MapFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = std::filesystem::path(::testing::TempDir()) /
                 ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(directory_ / "images");
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }
  void write(const std::filesystem::path& name, std::string_view content) {
    std::ofstream(directory_ / name, std::ios::binary) << content;
  }
  std::filesystem::path directory_;
};

TEST_F(MapFiles, AreReadWithTheImageBesideTheYaml) {
  const auto png = encode_grid_png(small_grid());
  write("map.yaml", encode_grid_yaml(small_grid(), "images/map.png"));
  write("images/map.png", {reinterpret_cast<const char*>(png.data()), png.size()});
  const auto grid = read_map_files(directory_ / "map.yaml");
  ASSERT_TRUE(grid.ok()) << grid.error().message;
  EXPECT_EQ(*grid, small_grid());
}

TEST_F(MapFiles, TakeTheImageBesideTheYamlForOneOfAnotherComputer) {
  const auto png = encode_grid_png(small_grid());
  write("map.png", {reinterpret_cast<const char*>(png.data()), png.size()});
  for (const char* image : {"/home/someone/maps/map.png", "C:\\maps\\map.png", "../gone/map.png"}) {
    write("map.yaml", encode_grid_yaml(small_grid(), image));
    const auto files = load_map_files(directory_ / "map.yaml");
    ASSERT_TRUE(files.ok()) << files.error().message;
    EXPECT_EQ(files->image_path, directory_ / "map.png");
    EXPECT_NE(files->note.find(image), std::string::npos) << files->note;
    EXPECT_EQ(read_map_files(directory_ / "map.yaml").value(), small_grid());
  }
}

TEST_F(MapFiles, TakeAPathOfWindows) {
  const auto png = encode_grid_png(small_grid());
  write("images/map.png", {reinterpret_cast<const char*>(png.data()), png.size()});
  write("map.yaml", encode_grid_yaml(small_grid(), "images\\map.png"));
  const auto files = load_map_files(directory_ / "map.yaml");
  ASSERT_TRUE(files.ok()) << files.error().message;
  EXPECT_EQ(files->image_path, directory_ / "images/map.png");
  EXPECT_EQ(files->note, "");
}

TEST_F(MapFiles, TakeTheImageThatWasRenamedWithItsYaml) {
  const auto png = encode_grid_png(small_grid());
  write("second floor.png", {reinterpret_cast<const char*>(png.data()), png.size()});
  write("second floor.yaml", encode_grid_yaml(small_grid(), "map.png"));
  const auto files = load_map_files(directory_ / "second floor.yaml");
  ASSERT_TRUE(files.ok()) << files.error().message;
  EXPECT_EQ(files->image_path, directory_ / "second floor.png");
  EXPECT_NE(files->note.find("map.png is not there"), std::string::npos) << files->note;
}

TEST_F(MapFiles, SayWhichFileIsMissing) {
  write("map.yaml", encode_grid_yaml(small_grid(), "images/gone.png"));
  const auto no_image = read_map_files(directory_ / "map.yaml");
  ASSERT_FALSE(no_image.ok());
  EXPECT_EQ(no_image.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(no_image.error().field, (directory_ / "images/gone.png").string());
  EXPECT_NE(no_image.error().message.find("whose image is images/gone.png"), std::string::npos);
  const auto no_yaml = read_map_files(directory_ / "gone.yaml");
  ASSERT_FALSE(no_yaml.ok());
  EXPECT_EQ(no_yaml.error().code, ErrorCode::kNotFound);
}

TEST_F(MapFiles, NameTheFileAndTheWrongKey) {
  write("map.yaml", "image: map.png\nresolution: -1\norigin: [0, 0, 0]\n");
  const auto grid = read_map_files(directory_ / "map.yaml");
  ASSERT_FALSE(grid.ok());
  EXPECT_EQ(grid.error().field, (directory_ / "map.yaml").string());
  EXPECT_EQ(grid.error().message, "resolution: expected metres per cell from 0.001 to 100, not -1");
}

/// A room of 6 x 6 pixels whose walls have the given grey value, in unknown space.
std::string room_pgm(int wall) {
  std::string pgm = "P5 8 8 255\n";
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 8; ++column) {
      const int ring = std::min({row, column, 7 - row, 7 - column});
      pgm += bytes({ring == 0 ? 205 : ring == 1 ? wall : 254});
    }
  }
  return pgm;
}

std::optional<std::string> advice(const std::string& yaml, const std::string& image) {
  return threshold_advice(yaml, std::as_bytes(std::span(image)));
}

TEST(ThresholdAdvice, NamesAThresholdThatMakesWalls) {
  EXPECT_EQ(advice(kYaml, room_pgm(100)),
            "at occupied_thresh 0.65 only 0 % of the border of free space is wall; occupied_thresh "
            "0.5 would make it 100 %");
}

TEST(ThresholdAdvice, SaysNothingWhereWallsAreWalls) {
  EXPECT_EQ(advice(kYaml, room_pgm(0)), std::nullopt);
  EXPECT_EQ(advice("nonsense", room_pgm(0)), std::nullopt);
}

TEST(ThresholdAdvice, OnlyComplainsWhereNoThresholdHelps) {
  EXPECT_EQ(advice(kYaml, room_pgm(205)),
            "at occupied_thresh 0.65 only 0 % of the border of free space is wall");
}

TEST(UnreadKeys, NamesWhatNoMapServerReads) {
  const std::string yaml = "image: a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n";
  EXPECT_EQ(unread_keys(yaml + "negate: 0\nmode: raw\nfree_thresh: 0.1\noccupied_thresh: 0.5\n"),
            std::nullopt);
  EXPECT_EQ(unread_keys("nonsense"), std::nullopt);
  EXPECT_EQ(unread_keys(yaml + "occupied_threshold: 0.9\nfloor: [1, 2]\n"),
            "keys that are not read: occupied_threshold, floor; read are image, resolution, "
            "origin, negate, occupied_thresh, free_thresh and mode");
}

TEST(UnknownAdvice, NamesAFreeThresholdThatTakesUnknownForFree) {
  const std::string yaml = "image: a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n";
  const auto advice_for = [&](const std::string& lines, std::initializer_list<int> pixels) {
    const std::string image = "P5\n4 1\n255\n" + bytes(pixels);
    return unknown_advice(yaml + lines, std::as_bytes(std::span(image)));
  };
  EXPECT_EQ(advice_for("free_thresh: 0.25\n", {0, 205, 205, 254}),
            "at free_thresh 0.25 50 % of the cells are free that free_thresh 0.196 leaves unknown; "
            "map_saver writes unknown cells in such a grey (205)");
  EXPECT_EQ(advice_for("free_thresh: 0.196\n", {0, 205, 205, 254}), std::nullopt);
  EXPECT_EQ(advice_for("free_thresh: 0.25\n", {0, 254, 254, 254}), std::nullopt);
}

}  // namespace
}  // namespace cornerfix

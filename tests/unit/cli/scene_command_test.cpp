// `cornerfix scene` as a user calls it.
#include <cornerfix/map_image.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "evaluation/simulation/scenes.hpp"
#include "unit/cli/command_run.hpp"

namespace cornerfix::cli {
namespace {

TEST(SceneCommand, WritesAMapServerMap) {
  const testing::TemporaryDirectory directory;
  const std::string out = (directory.path() / "flat").string();
  ASSERT_EQ(run({"scene", "home", out, "--layout-seed", "3", "--change-seed", "4"}).exit_code, 0);
  const Result<OccupancyGrid> read = read_map_files(out + ".yaml");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->cells, evaluation::make_scene(evaluation::SceneKind::kHome, 3, 4).cells);
}

TEST(SceneCommand, TakesTheNameOfTheYamlToo) {
  const testing::TemporaryDirectory directory;
  const std::string out = (directory.path() / "flat.yaml").string();
  ASSERT_EQ(run({"scene", "home", out}).exit_code, 0);
  EXPECT_TRUE(read_map_files(out));
}

TEST(SceneCommand, EndsAnUnknownKindWithTwoAndAMissingFolderWithOne) {
  const testing::TemporaryDirectory directory;
  EXPECT_EQ(run({"scene", "castle", (directory.path() / "a").string()}).exit_code, 2);
  EXPECT_EQ(run({"scene", "home", (directory.path() / "no" / "a").string()}).exit_code, 1);
}

}  // namespace
}  // namespace cornerfix::cli

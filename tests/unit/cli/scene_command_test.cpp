// `cornerfix scene` as a user calls it.
#include <cornerfix/map_image.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/command_line.hpp"
#include "evaluation/simulation/scenes.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::cli {
namespace {

int run(std::vector<std::string> arguments) {
  std::vector<const char*> argv = {"cornerfix"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const int exit_code = run_command_line(static_cast<int>(argv.size()), argv.data());
  ::testing::internal::GetCapturedStdout();
  ::testing::internal::GetCapturedStderr();
  return exit_code;
}

TEST(SceneCommand, WritesAMapServerMap) {
  const testing::TemporaryDirectory directory;
  const std::string out = (directory.path() / "flat").string();
  ASSERT_EQ(run({"scene", "home", out, "--layout-seed", "3", "--change-seed", "4"}), 0);
  const Result<OccupancyGrid> read = read_map_files(out + ".yaml");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->cells, evaluation::make_scene(evaluation::SceneKind::kHome, 3, 4).cells);
}

TEST(SceneCommand, TakesTheNameOfTheYamlToo) {
  const testing::TemporaryDirectory directory;
  const std::string out = (directory.path() / "flat.yaml").string();
  ASSERT_EQ(run({"scene", "home", out}), 0);
  EXPECT_TRUE(read_map_files(out));
}

TEST(SceneCommand, EndsAnUnknownKindWithTwoAndAMissingFolderWithOne) {
  const testing::TemporaryDirectory directory;
  EXPECT_EQ(run({"scene", "castle", (directory.path() / "a").string()}), 2);
  EXPECT_EQ(run({"scene", "home", (directory.path() / "no" / "a").string()}), 1);
}

}  // namespace
}  // namespace cornerfix::cli

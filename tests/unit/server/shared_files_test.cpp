#include "server/shared_files.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "support/temporary_directory.hpp"

namespace cornerfix::server {
namespace {

Result<std::string> converted(const std::string& yaml) {
  const testing::TemporaryDirectory directory;
  std::ofstream(directory / "a.yaml") << yaml;
  return yaml_file_as_json(directory / "a.yaml");
}

TEST(YamlAsJson, GivesPlainScalarsTheirTypesAndQuotedOnesTheirText) {
  EXPECT_EQ(*converted("a: 1\nb: 1.5\nc: true\nd: null\ne: text\nf: '1'\ng: \"true\"\nh: 3.1.0\n"),
            R"({"a":1,"b":1.5,"c":true,"d":null,"e":"text","f":"1","g":"true","h":"3.1.0"})");
}

TEST(YamlAsJson, KeepsOrderAndNesting) {
  EXPECT_EQ(*converted("z: [1, {b: 2}]\na: {}\n'200': []\n"),
            R"({"z":[1,{"b":2}],"a":{},"200":[]})");
}

TEST(YamlAsJson, SaysWhatIsWrong) {
  EXPECT_FALSE(converted("a: [1"));
  EXPECT_FALSE(yaml_file_as_json("/nowhere/a.yaml"));
}

TEST(SharedFiles, AreFoundInTheSourceTree) {
  EXPECT_TRUE(std::filesystem::exists(find_web_root() / "index.html"));
}

}  // namespace
}  // namespace cornerfix::server

#include "server/shared_files.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

TEST(SharedFiles, AreFoundInTheSourceTree) {
  EXPECT_TRUE(std::filesystem::exists(find_web_root() / "index.html"));
}

}  // namespace
}  // namespace cornerfix::server

#include "server/store_access.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "support/temporary_directory.hpp"

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;

class StoreAccessTest : public ::testing::Test {
 protected:
  void expect_unavailable() {
    const auto epoch = stores_->epoch();
    ASSERT_FALSE(epoch);
    EXPECT_EQ(epoch.error().code, ErrorCode::kUnavailable);
    const auto count =
        stores_->with_sessions([](storage::SessionStore& sessions) { return sessions.count("a"); });
    EXPECT_FALSE(count);
    const auto list = stores_->with_maps([](storage::MapStore& maps) { return maps.list("", 1); });
    ASSERT_FALSE(list);
    EXPECT_THAT(list.error().message, HasSubstr("deleted or replaced"));
    EXPECT_FALSE(stores_->probe(0));
  }

  testing::TemporaryDirectory directory_;
  std::filesystem::path file_ = directory_ / "test.db";
  std::shared_ptr<StoreAccess> stores_ = StoreAccess::open(file_).value();
};

TEST_F(StoreAccessTest, NoticesThatItsFileWasDeleted) {
  EXPECT_TRUE(stores_->probe(0));
  std::filesystem::remove(file_);
  expect_unavailable();
}

TEST_F(StoreAccessTest, NoticesThatItsFileWasReplaced) {
  std::filesystem::copy(file_, directory_ / "copy.db");
  std::filesystem::rename(directory_ / "copy.db", file_);
  expect_unavailable();
}

TEST_F(StoreAccessTest, NeedsRoomToStore) {
  const auto probe = stores_->probe(std::numeric_limits<std::uint64_t>::max());
  ASSERT_FALSE(probe);
  EXPECT_THAT(probe.error().message, HasSubstr("bytes left"));
}

}  // namespace
}  // namespace cornerfix::server

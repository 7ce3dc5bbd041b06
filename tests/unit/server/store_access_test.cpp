#include "server/store_access.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <future>
#include <limits>
#include <string>

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

TEST_F(StoreAccessTest, NoticesThatTheWriteAheadLogOrItsIndexWasDeleted) {
  for (const std::string companion : {"-wal", "-shm"}) {
    const std::filesystem::path file = directory_ / ("without" + companion + ".db");
    stores_ = StoreAccess::open(file).value();
    ASSERT_TRUE(stores_->probe(0));
    ASSERT_TRUE(std::filesystem::remove(file.string() + companion)) << companion;
    expect_unavailable();
  }
}

TEST_F(StoreAccessTest, WaitsForOtherCallsNoLongerThanForAnotherProcess) {
  stores_ = StoreAccess::open(file_, 1).value();
  const auto other = stores_->with_sessions([&](storage::SessionStore&) {
    return std::async(std::launch::async, [&] { return stores_->epoch(); }).get();
  });
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(stores_->epoch());
}

TEST_F(StoreAccessTest, NeedsRoomToStore) {
  const auto probe = stores_->probe(std::numeric_limits<std::uint64_t>::max());
  ASSERT_FALSE(probe);
  EXPECT_THAT(probe.error().message, HasSubstr("bytes left"));
}

/// Overwrites all pages but the first.
void damage(const std::filesystem::path& file) {
  constexpr std::size_t kPage = 4096;
  const std::size_t size = std::filesystem::file_size(file);
  ASSERT_GT(size, kPage);
  std::fstream pages(file, std::ios::in | std::ios::out | std::ios::binary);
  pages.seekp(kPage);
  pages << std::string(size - kPage, '\xff');
}

TEST_F(StoreAccessTest, IsNotReadyWithDamagedPages) {
  stores_.reset();  // Its WAL goes into the file.
  stores_ = StoreAccess::open(file_).value();
  damage(file_);
  const auto probe = stores_->probe(0);
  ASSERT_FALSE(probe);
  EXPECT_EQ(probe.error().code, ErrorCode::kCorruptData);
}

TEST_F(StoreAccessTest, IsNotReadyWhenItCannotWrite) {
  const auto other = storage::Database::open(file_, storage::Synchronous::kNormal).value();
  const auto held = other->begin(storage::Access::kWrite);
  stores_ = StoreAccess::open(file_, 0).value();  // Waits for no other writer.
  const auto probe = stores_->probe(0);
  ASSERT_FALSE(probe);
  EXPECT_EQ(probe.error().code, ErrorCode::kUnavailable);
}

TEST_F(StoreAccessTest, LeavesSessionsCurrentWhenItTriesToWrite) {
  const auto before = stores_->epoch();
  EXPECT_TRUE(stores_->probe(0));
  EXPECT_EQ(stores_->epoch().value(), before.value());
}

}  // namespace
}  // namespace cornerfix::server

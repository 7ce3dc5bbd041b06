#include "storage/token_store.hpp"

#include <gmock/gmock.h>

#include "unit/storage/engines.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class TokenStoreTest : public EngineTest {
 protected:
  static TokenRecord token(const std::string& text) {
    return {.name = "holder of " + text,
            .role = "robot",
            .maps = {"office", "lab"},
            .hash = hash_of_token(text),
            .created = "2024-05-01T00:00:00Z",
            .expires = "2025-05-01T00:00:00Z"};
  }

  std::shared_ptr<Database> database_ = databases_.open("tokens");
  TokenStore store_{database_};
};

INSTANTIATE_TEST_SUITE_P(Engines, TokenStoreTest, ::testing::ValuesIn(engines()), EngineName());

TEST_P(TokenStoreTest, GivesBackATokenAsItWas) {
  const std::int64_t id = store_.insert(token("a")).value();
  const std::vector<TokenRecord> stored = store_.list().value();
  ASSERT_EQ(stored.size(), 1U);
  EXPECT_EQ(stored[0].id, id);
  EXPECT_EQ(stored[0].name, "holder of a");
  EXPECT_EQ(stored[0].role, "robot");
  EXPECT_THAT(stored[0].maps, ElementsAre("office", "lab"));
  EXPECT_EQ(stored[0].hash, hash_of_token("a"));
  EXPECT_EQ(stored[0].created, "2024-05-01T00:00:00Z");
  EXPECT_EQ(stored[0].expires, "2025-05-01T00:00:00Z");
}

TEST_P(TokenStoreTest, KeepsATokenForAllMaps) {
  TokenRecord all = token("a");
  all.maps.clear();
  ASSERT_TRUE(store_.insert(all));
  EXPECT_THAT(store_.list().value()[0].maps, IsEmpty());
}

TEST_P(TokenStoreTest, RefusesASecondTokenOfTheSameHash) {
  ASSERT_TRUE(store_.insert(token("a")));
  EXPECT_EQ(store_.insert(token("a")).error().code, ErrorCode::kConflict);
}

TEST_P(TokenStoreTest, RemovesOneTokenAndNeverGivesItsIdToAnother) {
  const std::int64_t first = store_.insert(token("a")).value();
  const std::int64_t second = store_.insert(token("b")).value();
  ASSERT_TRUE(store_.remove(second));
  EXPECT_EQ(store_.remove(second).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store_.list().value().at(0).id, first);
  EXPECT_GT(store_.insert(token("c")).value(), second);
}

TEST_P(TokenStoreTest, ShowsOtherConnectionsThatATokenWasAddedOrRemoved) {
  const std::shared_ptr<Database> other = databases_.open("tokens");
  const std::int64_t before = other->data_version().value();
  const std::int64_t id = store_.insert(token("a")).value();
  const std::int64_t added = other->data_version().value();
  EXPECT_NE(added, before);
  ASSERT_TRUE(store_.remove(id));
  EXPECT_NE(other->data_version().value(), added);
}

TEST(RandomToken, HasA256BitNumberBehindItsPrefixAndComesOnce) {
  const std::string token = random_token();
  EXPECT_THAT(token, ::testing::MatchesRegex("cfx_[0-9a-f]{64}"));
  EXPECT_NE(random_token(), token);
}

}  // namespace
}  // namespace cornerfix::storage

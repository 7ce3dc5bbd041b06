#include "server/map_cache.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

LocalizationMapPtr make_map(std::uint64_t revision) {
  return std::make_shared<const LocalizationMap>("office", revision, MapContent{});
}

TEST(MapCache, FindsAMapWithoutRoomAsLongAsSomebodyHoldsIt) {
  MapCache cache(0);
  LocalizationMapPtr held = make_map(1);
  cache.keep({1, 1}, held);
  cache.keep({2, 1}, make_map(1));
  EXPECT_EQ(cache.find({1, 1}), held);
  held.reset();
  cache.keep({3, 1}, make_map(1));  // The newest stays.
  EXPECT_EQ(cache.find({1, 1}), nullptr);
  EXPECT_EQ(cache.use().maps, 1U);
}

TEST(MapCache, CountsMapsThatOthersHoldAndReleasesThemLater) {
  const std::size_t size = make_map(1)->bytes();
  MapCache cache(2 * size);
  LocalizationMapPtr held = make_map(1);
  cache.keep({1, 1}, held);
  for (const std::int64_t id : {2, 3, 4}) cache.keep({id, 1}, make_map(1));
  EXPECT_EQ(cache.use().maps, 2U);
  EXPECT_EQ(cache.use().bytes, 2 * size);
  EXPECT_EQ(cache.find({3, 1}), nullptr);
  EXPECT_NE(cache.find({4, 1}), nullptr);
  LocalizationMapPtr other = make_map(1);
  cache.keep({5, 1}, other);
  LocalizationMapPtr third = make_map(1);
  cache.keep({6, 1}, third);
  EXPECT_EQ(cache.use().maps, 3U);
  EXPECT_FALSE(cache.make_room());
  other.reset();
  held.reset();
  EXPECT_TRUE(cache.make_room());
  EXPECT_EQ(cache.use().bytes, size);  // A tenth of the room is free.
  EXPECT_EQ(cache.find({6, 1}), third);
}

TEST(MapCache, KnowsOneRevisionOfAMapFromAnother) {
  MapCache cache(std::size_t{1} << 30U);
  cache.keep({1, 1}, make_map(1));
  const LocalizationMapPtr newer = make_map(2);
  cache.keep({1, 2}, newer);
  EXPECT_EQ(cache.find({1, 1}), nullptr);
  EXPECT_EQ(cache.find({1, 2}), newer);
}

}  // namespace
}  // namespace cornerfix::server

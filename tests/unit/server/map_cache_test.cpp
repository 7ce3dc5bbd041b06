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
  cache.keep({2, 1}, make_map(1));  // The newest stays, so the first has to go.
  EXPECT_EQ(cache.use().maps, 1U);
  EXPECT_EQ(cache.find({1, 1}), held);
  held.reset();
  EXPECT_EQ(cache.find({1, 1}), nullptr);
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

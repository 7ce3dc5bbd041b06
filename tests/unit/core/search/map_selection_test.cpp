#include "core/src/search/map_selection.hpp"

#include <gmock/gmock.h>

#include <memory>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/src/search/global_search.hpp"

namespace cornerfix {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Maps 1 to `size` without content, named "map-KEY". rank() gives `ranking`.
class StubSource : public MapSource {
 public:
  explicit StubSource(std::size_t size) : size_(size) {}

  std::size_t size() override { return size_; }
  double free_area_m2() override { return 0.0; }
  std::vector<RankedMap> rank(const MapQuery& /*query*/) override { return ranking; }
  std::vector<MapKey> keys() override {
    std::vector<MapKey> keys(size_);
    std::iota(keys.begin(), keys.end(), MapKey{1});
    return keys;
  }
  std::optional<MapKey> find(std::string_view name) override {
    for (const MapKey key : keys()) {
      if (name_of(key) == name) return key;
    }
    return std::nullopt;
  }
  LocalizationMapPtr load(MapKey key, std::size_t /*held_bytes*/) override {
    if (absent.contains(key)) return nullptr;
    return std::make_shared<const LocalizationMap>(name_of(key), 1, MapContent{});
  }

  std::vector<RankedMap> ranking;
  std::set<MapKey> absent;  ///< Cannot be loaded.

 private:
  static std::string name_of(MapKey key) { return "map-" + std::to_string(key); }

  std::size_t size_;
};

View view_with(std::size_t corners) {
  View view;
  view.corners.resize(corners);
  return view;
}

MapSelection select(StubSource& source, std::size_t corners, double distance_m = 0.0,
                    const std::optional<StartRegion>& region = std::nullopt,
                    MapSelection kept = {}) {
  return select_maps(source, view_with(corners),
                     {.kept = std::move(kept), .region = region, .distance_m = distance_m});
}

/// Maps 1, 2, … with these weights.
std::vector<RankedMap> ranked(const std::vector<double>& weights) {
  std::vector<RankedMap> maps;
  for (const double weight : weights)
    maps.push_back({static_cast<MapKey>(maps.size() + 1), weight, {}});
  return maps;
}

TEST(MapSelection, TakesTheRankedMapsThatAreNearlyAsGoodAsTheBest) {
  StubSource source(50);
  source.ranking = ranked({0.40, 0.30, 0.21, 0.19, 0.10});
  const MapSelection selection = select(source, kEnoughCorners);
  EXPECT_THAT(selection.keys, ElementsAre(1, 2, 3));
  EXPECT_THAT(selection.maps, SizeIs(3));
  EXPECT_TRUE(selection.is_ranked);
  EXPECT_EQ(selection.unsearched, 0U);
}

TEST(MapSelection, CountsLikelyMapsThatCannotBeLoaded) {
  StubSource source(50);
  source.ranking = ranked({0.4, 0.4, 0.4});
  source.absent = {2};
  const MapSelection selection = select(source, kEnoughCorners);
  EXPECT_THAT(selection.keys, ElementsAre(1, 3));
  EXPECT_EQ(selection.unsearched, 1U);
}

TEST(MapSelection, LoadsAtMost32RankedMaps) {
  StubSource source(50);
  source.ranking = ranked(std::vector<double>(40, 0.4));
  const MapSelection selection = select(source, kEnoughCorners);
  EXPECT_THAT(selection.keys, SizeIs(32));
  EXPECT_EQ(selection.unsearched, 8U);
}

TEST(MapSelection, TakesAllOfFewMapsWithoutRanking) {
  StubSource source(kFewMaps);
  const MapSelection selection = select(source, kEnoughCorners);
  EXPECT_THAT(selection.keys, ElementsAre(1, 2, 3, 4));
  EXPECT_FALSE(selection.is_ranked);
  EXPECT_EQ(selection.unsearched, 0U);
}

TEST(MapSelection, TakesFourProposalsWhenCornersAreFewAndAllMapsAfterThreeMetres) {
  StubSource source(50);
  source.ranking = ranked({0.4, 0.3, 0.1, 0.0, -0.1});
  const MapSelection first = select(source, kEnoughCorners - 1);
  EXPECT_THAT(first.keys, ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(first.unsearched, 46U);
  const MapSelection later = select(source, kEnoughCorners - 1, 3.0);
  EXPECT_THAT(later.keys, SizeIs(50));
  EXPECT_EQ(later.unsearched, 0U);
}

TEST(MapSelection, TakesNoneOfMoreThan128MapsWhenCornersAreFew) {
  StubSource source(129);
  source.ranking = ranked({0.4});
  const MapSelection selection = select(source, kEnoughCorners - 1, 10.0);
  EXPECT_THAT(selection.keys, IsEmpty());
  EXPECT_EQ(selection.unsearched, 129U);
}

TEST(MapSelection, TakesTheMapOfAStartRegionOnly) {
  StubSource source(50);
  source.ranking = ranked({0.4});
  const StartRegion region{.map = "map-7", .radius_m = 1.0};
  EXPECT_THAT(select(source, kEnoughCorners, 0.0, region).keys, ElementsAre(7));
  source.absent = {7};
  const MapSelection none = select(source, kEnoughCorners, 0.0, region);
  EXPECT_THAT(none.keys, IsEmpty());
  EXPECT_EQ(none.unsearched, 1U);
}

TEST(MapSelection, PutsKeptMapsFirstAndLoadsThemOnce) {
  StubSource source(50);
  source.ranking = ranked({0.4, 0.4});
  MapSelection kept;
  kept.keys = {2};
  kept.maps = {source.load(2, 0)};
  const LocalizationMapPtr held = kept.maps.front();
  const MapSelection selection = select(source, kEnoughCorners, 0.0, std::nullopt, std::move(kept));
  EXPECT_THAT(selection.keys, ElementsAre(2, 1));
  EXPECT_EQ(selection.maps.front(), held);
}

}  // namespace
}  // namespace cornerfix

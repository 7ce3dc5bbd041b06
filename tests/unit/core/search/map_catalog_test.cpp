#include <cornerfix/map_source.hpp>

#include <gmock/gmock.h>

#include <optional>
#include <vector>

#include <cornerfix/mapper.hpp>

#include "support/seen_view.hpp"
#include "support/simulated_drive.hpp"
#include "support/storeys.hpp"

namespace cornerfix {
namespace {

using testing::random_storey;
using testing::Storey;

constexpr std::uint64_t kFirstSeed = 500;
constexpr std::size_t kStoreys = 8;

MapSketch sketch_of_storey(const Storey& storey) {
  const Result<GridMap> made = map_from_grid(storey.grid(), {});
  return sketch_of(made.value().content.features, made.value().content.grid);
}

/// Sketches of storeys that differ, made once.
const std::vector<MapSketch>& sketches() {
  static const std::vector<MapSketch> kSketches = [] {
    std::vector<MapSketch> made;
    for (std::size_t i = 0; i < kStoreys; ++i)
      made.push_back(sketch_of_storey(random_storey(kFirstSeed + i)));
    return made;
  }();
  return kSketches;
}

MapCatalog catalog_of_storeys() {
  MapCatalog catalog;
  for (std::size_t i = 0; i < kStoreys; ++i) catalog.put(static_cast<MapKey>(i), sketches()[i]);
  return catalog;
}

std::vector<Pose2> first_poses(const Storey& storey, std::size_t scans = 24) {
  return testing::wander(storey.scene, {storey.inside.x() + 1.0, storey.inside.y(), 0.3}, scans);
}

std::vector<RankedMap> ranking_of(const MapCatalog& catalog, const View& view) {
  return catalog.rank({view.corners, view.evidence.ends});
}

TEST(MapCatalog, RanksTheMapOfTheRobotFirstAtItsPose) {
  const MapCatalog catalog = catalog_of_storeys();
  for (std::size_t i = 0; i < kStoreys; ++i) {
    SCOPED_TRACE(i);
    const Storey storey = random_storey(kFirstSeed + i);
    const std::vector<Pose2> poses = first_poses(storey);
    const auto ranked = ranking_of(catalog, testing::view_along(storey.scene, poses));
    ASSERT_FALSE(ranked.empty());
    EXPECT_EQ(ranked.front().key, static_cast<MapKey>(i));
    EXPECT_LT(distance(ranked.front().T_map_base_link, poses.back()), 0.4);
    EXPECT_LT(angle_between(ranked.front().T_map_base_link, poses.back()), 0.1);
    EXPECT_GT(ranked.front().mean_weight, 0.35);
  }
}

TEST(MapCatalog, RanksMapsThatCameTogetherAsThoseThatCameOneByOne) {
  std::vector<std::pair<MapKey, MapSketch>> maps;
  for (std::size_t i = 0; i < kStoreys; ++i) maps.emplace_back(7, sketches()[kStoreys - 1 - i]);
  for (std::size_t i = 0; i < kStoreys; ++i)
    maps.emplace_back(static_cast<MapKey>(i), sketches()[i]);
  MapCatalog together;
  together.put_all(std::move(maps));
  EXPECT_EQ(together.size(), kStoreys);
  const MapCatalog one_by_one = catalog_of_storeys();
  EXPECT_NEAR(together.free_area_m2(), one_by_one.free_area_m2(), 1e-6);
  const Storey storey = random_storey(kFirstSeed + 3);
  const View view = testing::view_along(storey.scene, first_poses(storey));
  const auto ranked = ranking_of(together, view);
  const auto expected = ranking_of(one_by_one, view);
  ASSERT_EQ(ranked.size(), expected.size());
  ASSERT_FALSE(ranked.empty());
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    EXPECT_EQ(ranked[i].key, expected[i].key);
    EXPECT_EQ(ranked[i].mean_weight, expected[i].mean_weight);
  }
}

TEST(MapCatalog, RanksTwinsAlike) {
  MapCatalog catalog = catalog_of_storeys();
  catalog.put(100, sketches()[2]);
  const Storey storey = random_storey(kFirstSeed + 2);
  const auto ranked = ranking_of(catalog, testing::view_along(storey.scene, first_poses(storey)));
  ASSERT_GE(ranked.size(), 2U);
  EXPECT_EQ(ranked[0].key, 2);
  EXPECT_EQ(ranked[1].key, 100);
  EXPECT_EQ(ranked[0].mean_weight, ranked[1].mean_weight);
}

TEST(MapCatalog, DoesNotFindAMapThatWasErasedOrReplaced) {
  MapCatalog catalog = catalog_of_storeys();
  const Storey storey = random_storey(kFirstSeed + 3);
  const View view = testing::view_along(storey.scene, first_poses(storey));
  catalog.put(3, sketches()[4]);
  catalog.put(50, sketches()[3]);
  EXPECT_EQ(ranking_of(catalog, view).front().key, 50);
  catalog.erase(50);
  catalog.erase(50);
  EXPECT_FALSE(catalog.contains(50));
  EXPECT_EQ(catalog.size(), kStoreys);
  for (const RankedMap& one : ranking_of(catalog, view)) EXPECT_LT(one.mean_weight, 0.35);
}

TEST(MapCatalog, KeepsItsSizeWhileAMapChangesOftenAndFindsItsLastRevision) {
  MapCatalog catalog = catalog_of_storeys();
  const std::size_t bytes = catalog.bytes();
  const double area_m2 = catalog.free_area_m2();
  for (std::size_t i = 0; i <= 100 * kStoreys; ++i) catalog.put(0, sketches()[i % kStoreys]);
  EXPECT_EQ(catalog.size(), kStoreys);
  EXPECT_NEAR(catalog.free_area_m2(), area_m2, 1e-6);
  EXPECT_LT(catalog.bytes(), 4 * bytes);
  const Storey storey = random_storey(kFirstSeed);
  EXPECT_EQ(ranking_of(catalog, testing::view_along(storey.scene, first_poses(storey))).front().key,
            0);
}

TEST(MapCatalog, RanksNothingWithoutMapsOrHits) {
  const Storey storey = random_storey(kFirstSeed);
  const View view = testing::view_along(storey.scene, first_poses(storey));
  EXPECT_TRUE(ranking_of(MapCatalog(), view).empty());
  EXPECT_TRUE(catalog_of_storeys().rank({view.corners, {}}).empty());
  EXPECT_TRUE(catalog_of_storeys().rank({{}, view.evidence.ends}).empty());
}

TEST(MapCatalog, NeedsLessThanAKilobytePerFeature) {
  MapCatalog catalog;
  const std::size_t empty = [] {
    MapCatalog one;
    one.put(1, {});
    return one.bytes();
  }();
  std::size_t features = 0;
  for (std::size_t i = 0; i < kStoreys; ++i) {
    catalog.put(static_cast<MapKey>(i), sketches()[i]);
    features += sketches()[i].corners.size();
  }
  EXPECT_LT(catalog.bytes() - empty, 1000 * features);
}

}  // namespace
}  // namespace cornerfix

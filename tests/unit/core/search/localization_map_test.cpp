#include <cornerfix/localization_map.hpp>

#include <gtest/gtest.h>

#include "core/src/search/map_index.hpp"
#include "support/floor_plans.hpp"

namespace cornerfix {
namespace {

TEST(LocalizationMap, HoldsItsContent) {
  const MapContent content =
      testing::map_content(testing::mapping_scans(testing::offices(), {1.0, 1.0}));
  const LocalizationMap map("offices", 7, content);
  EXPECT_EQ(map.name(), "offices");
  EXPECT_EQ(map.revision(), 7U);
  EXPECT_EQ(map.features().size(), content.features.size());
  EXPECT_EQ(map.grid(), content.grid);
  EXPECT_EQ(map.descriptor_params(), content.descriptors.params);
  EXPECT_DOUBLE_EQ(map.free_area_m2(), content.grid.free_area_m2());
}

TEST(LocalizationMap, IndexesWhatItHolds) {
  const LocalizationMapPtr map = testing::make_map(testing::offices(), {1.0, 1.0});
  const MapIndex& index = map->index();
  EXPECT_EQ(index.descriptor_index.size(), map->features().size());
  EXPECT_GT(index.triangle_index.triangle_count(), 0U);
  EXPECT_EQ(index.classes.width(), map->grid().width);
  EXPECT_EQ(index.field.height(), map->grid().height);
  EXPECT_GT(map->bytes(), index.bytes());
}

TEST(LocalizationMap, StaysValidWhenMoved) {
  LocalizationMap map("offices", 1,
                      testing::map_content(testing::mapping_scans(testing::offices(), {1.0, 1.0})));
  const std::size_t bytes = map.bytes();
  const LocalizationMap moved = std::move(map);
  EXPECT_EQ(moved.bytes(), bytes);
}

TEST(LocalizationMap, MayBeEmpty) {
  const LocalizationMap map("empty", 1, {});
  EXPECT_TRUE(map.features().empty());
  EXPECT_EQ(map.free_area_m2(), 0.0);
}

}  // namespace
}  // namespace cornerfix

#include "core/src/search/map_index.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "support/floor_plans.hpp"
#include "support/map_maker.hpp"

namespace cornerfix {
namespace {

MapContent room_content() {
  return testing::map_content(testing::mapping_scans(testing::random_room(3), {0.0, 0.0}));
}

TEST(MapIndex, IndexesTheDescriptorsAndTheGridOfTheContent) {
  const MapContent content = room_content();
  const MapIndex index(content.features, content.descriptors, content.grid);
  EXPECT_EQ(index.descriptor_index.size(), content.features.size());
  EXPECT_EQ(index.classes.width(), content.grid.width);
  EXPECT_EQ(index.classes.height(), content.grid.height);
  EXPECT_EQ(index.field.steps().size(), content.grid.cells.size());
}

TEST(MapIndex, KeepsNoReferenceToTheContent) {
  auto content = std::make_unique<MapContent>(room_content());
  const Point2 origin = content->grid.T_map_grid.translation();
  const MapIndex index(content->features, content->descriptors, content->grid);
  const auto before = index.classes.packed(3, 3);
  content.reset();
  EXPECT_EQ(index.classes.packed(3, 3), before);
  EXPECT_LT((inverse(index.classes.T_grid_map()).translation() - origin).norm(), 1e-9);
}

TEST(MapIndex, CountsTheBytesOfAllItsParts) {
  const MapContent content = room_content();
  const MapIndex index(content.features, content.descriptors, content.grid);
  const std::size_t parts = sizeof(MapIndex) + index.descriptor_index.bytes() +
                            index.triangle_index.memory_bytes() + content.grid.cells.size() +
                            index.classes.bytes() + index.place_search.bytes();
  EXPECT_EQ(index.bytes(), parts);
}

}  // namespace
}  // namespace cornerfix

/// \file  A store of maps in an empty database of each engine.
#pragma once

#include <string>
#include <vector>

#include "storage/map_store.hpp"
#include "unit/storage/engines.hpp"

namespace cornerfix::storage {

class MapStoreFixture : public EngineTest {
 protected:
  const MapOutline outline_{.feature_count = 7, .bounds = Bounds{{11.0, 20.0}, {13.0, 23.0}}};

  MapInfo make_map(const std::string& name = "office") {
    EXPECT_TRUE(store_.put(name, std::nullopt, std::nullopt, std::nullopt, "t0").value());
    return store_.find(name).value();
  }
  /// Adds `count` keyframes with their stamps.
  MapInfo grow(const MapInfo& map, int count, const std::string& now = "t1") {
    return grow(map, sample_key_frames(count), now);
  }
  MapInfo grow(const MapInfo& map, const std::vector<PosedScan>& key_frames,
               const std::string& now = "t1") {
    std::vector<double> stamps;
    for (const PosedScan& key_frame : key_frames) {
      stamps.push_back(key_frame.scan.stamp + static_cast<double>(map.key_frame_count) * 1000.0);
    }
    return store_.grow(map.id, map.revision, growth(stamps, key_frames), now).value();
  }
  static MapGrowth growth(std::span<const double> stamps, std::span<const PosedScan> key_frames) {
    return {.stamps = stamps,
            .new_key_frames = key_frames,
            .outline = {.feature_count = 12, .bounds = Bounds{{-1.0, -2.0}, {3.5, 4.5}}}};
  }
  std::int64_t count(const std::string& table) {
    return databases_.run("maps", "SELECT count(*) FROM " + table);
  }
  /// All of a store that a caller can see, to compare before with after.
  std::string dump() {
    std::string text;
    const std::vector<MapInfo> maps = store_.list("", 100).value();
    for (const MapInfo& map : maps) {
      text += map.name + " " + std::to_string(map.revision) + " " + map.digest + " " + map.updated;
      text += " " + std::to_string(map.key_frame_count) + " " + std::to_string(map.feature_count);
    }
    for (const char* table : {"maps", "key_frames", "map_stamps", "map_contents"}) {
      text += " " + std::to_string(count(table));
    }
    return text;
  }

  std::shared_ptr<Database> database_ = databases_.open("maps");
  MapStore store_{database_};
};

}  // namespace cornerfix::storage

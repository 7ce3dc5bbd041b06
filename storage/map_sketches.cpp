// The sketches of maps in a MapStore.
#include <utility>

#include "storage/blob_codec.hpp"
#include "storage/database.hpp"
#include "storage/map_source.hpp"
#include "storage/map_store.hpp"
#include "storage/map_tables.hpp"

namespace cornerfix::storage {

Result<std::vector<SketchState>> MapStore::sketch_states() {
  return guarded(
      [&]() -> Result<std::vector<SketchState>> { return database_->maps().sketch_states(); });
}

Result<SketchPage> MapStore::sketches(std::int64_t after, std::size_t limit) {
  return guarded([&]() -> Result<SketchPage> {
    const std::vector<SketchRow> rows = database_->maps().sketches(after, limit);
    SketchPage page;
    for (const SketchRow& row : rows) {
      auto sketch = decode_map_sketch(row.sketch);
      if (sketch) page.sketches.push_back({row.map, row.revision, std::move(*sketch)});
    }
    if (!rows.empty() && rows.size() == limit) page.next = rows.back().map;
    return page;
  });
}

Result<void> MapStore::store_sketch(std::int64_t map_id, std::uint64_t revision,
                                    const MapSketch& sketch) {
  return guarded([&]() -> Result<void> {
    const SketchRow row{.map = map_id, .revision = revision, .sketch = encode_map_sketch(sketch)};
    const auto transaction = database_->begin(Access::kWrite);
    MapTables& maps = database_->maps();
    if (!find_at_revision(maps, map_id, revision)) return {};  // The map has moved on.
    maps.put_sketch(row);
    transaction->commit();
    return {};
  });
}

}  // namespace cornerfix::storage

/// \file  The rows of maps, as an engine stores them. For MapStore, which has the rules.
///
/// Functions throw; MapStore calls them under guarded().
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "storage/blob_codec.hpp"
#include "storage/digest.hpp"
#include "storage/map_store.hpp"

namespace cornerfix::storage {

/// A map's row: its entry and what only storage needs.
struct MapRow {
  MapInfo info;
  KeyFrameChain chain{};
};

/// Derived content as BLOBs, with the revision it was made from.
struct ContentBlobs {
  std::uint64_t revision = 0;
  Blob features;
  Blob descriptors;
  Blob grid;
};

/// A sketch as a BLOB.
struct SketchRow {
  std::int64_t map = 0;
  std::uint64_t revision = 0;
  Blob sketch;
};

class MapTables {
 public:
  MapTables() = default;
  virtual ~MapTables() = default;
  MapTables(const MapTables&) = delete;
  MapTables& operator=(const MapTables&) = delete;

  virtual std::size_t count() = 0;
  /// By ascending bytes of the name.
  virtual std::vector<MapRow> list(std::string_view after, std::size_t limit) = 0;
  /// In a transaction that writes, other writers of the map then wait for its end.
  virtual std::optional<MapRow> find(std::string_view name) = 0;
  virtual std::optional<MapRow> find(std::int64_t id) = 0;
  /// Returns the new id; a row that has one keeps it.
  virtual std::int64_t insert(const MapRow& row) = 0;
  /// All but name and creation. `has_floor_map` is put_grid()'s.
  virtual void update(const MapRow& row) = 0;
  virtual void remove(std::string_view name) = 0;

  virtual std::vector<bool> known_stamps(std::int64_t map, std::span<const double> stamps) = 0;
  virtual bool holds_stamps(std::int64_t map) = 0;
  virtual std::vector<double> stamps(std::int64_t map) = 0;  ///< Ascending.
  virtual void insert_stamps(std::int64_t map, std::span<const double> stamps) = 0;

  /// Calls `use` with each, in order, until it returns false.
  virtual void read_key_frames(std::int64_t map, const std::function<bool(BlobView)>& use) = 0;
  virtual void insert_key_frame(std::int64_t map, std::size_t ordinal, BlobView scan) = 0;
  virtual void replace_key_frame(std::int64_t map, std::size_t ordinal, BlobView scan) = 0;

  virtual std::optional<Blob> grid(std::int64_t map) = 0;
  virtual void put_grid(std::int64_t map, BlobView grid) = 0;

  /// Keyframes, stamps and grid.
  virtual void remove_source(std::int64_t map) = 0;

  virtual std::vector<MapRevision> kept_revisions(std::int64_t map) = 0;  ///< Newest first.
  virtual std::optional<Blob> revision_archive(std::int64_t map, std::uint64_t revision) = 0;
  virtual void insert_revision(std::int64_t map, const MapRevision& revision, BlobView archive) = 0;
  /// All but the newest `kept`.
  virtual void remove_old_revisions(std::int64_t map, std::size_t kept) = 0;

  virtual std::optional<ContentBlobs> content(std::int64_t map) = 0;
  virtual void put_content(std::int64_t map, const ContentBlobs& content) = 0;

  virtual std::vector<SketchState> sketch_states() = 0;  ///< Of all maps, by id.
  /// By map, after `after`.
  virtual std::vector<SketchRow> sketches(std::int64_t after, std::size_t limit) = 0;
  virtual void put_sketch(const SketchRow& row) = 0;
  virtual void set_feature_count(std::int64_t map, std::size_t count) = 0;
};

}  // namespace cornerfix::storage

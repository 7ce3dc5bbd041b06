/// \file  Named maps in a database: keyframes (the source) and what is derived from them.
///
/// What a call has acknowledged is on disk (Synchronous::kFull). Every call is one transaction:
/// on an error nothing has changed. Not synchronised: a store belongs to one thread at a time; open
/// one a thread on the same database.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/map_sketch.hpp>
#include <cornerfix/mapper.hpp>
#include <cornerfix/result.hpp>

#include "storage/known_map.hpp"
#include "storage/map_archive.hpp"
#include "storage/map_revisions.hpp"

namespace cornerfix::storage {

class Database;

/// A map's entry, without its content.
struct MapInfo {
  std::int64_t id = 0;
  std::string name;
  std::string description;
  std::uint64_t revision = 0;  ///< From 1 on; grows by one with every change of content or lidar.
  std::string digest;  ///< Hex SHA-256 of the content: keyframes (or grid), parameters; not of
                       ///< names and dates.
  std::size_t key_frame_count = 0;
  std::size_t feature_count = 0;
  bool has_floor_map = false;    ///< It was made from an occupancy map, not from scans.
  std::optional<Bounds> bounds;  ///< None for a map without keyframes and grid.
  std::string created;           ///< RFC 3339, UTC.
  std::string updated;
  std::string lidar_json;       ///< As given by PUT, or empty; opaque to this module.
  std::string parameters_json;  ///< As given by PUT, or empty; opaque to this module.
  /// The keyframes stand at poses of lidar odometry: their trajectory is yet to be optimised.
  bool drifts = false;
  std::string revision_created;  ///< RFC 3339, UTC.
  RevisionOrigin revision_origin = RevisionOrigin::kUnknown;
};

/// The part of a map's entry that is derived from its content.
struct MapOutline {
  std::size_t feature_count = 0;
  std::optional<Bounds> bounds{};
};

/// What other parameters make of a map, worked out from its content.
struct MapRemake {
  KnownMap known{};      ///< With that content.
  MapOutline outline{};  ///< Of no meaning for a map without content.
};

/// What POST …/scans adds in one transaction.
struct MapGrowth {
  std::span<const double> stamps;  ///< Of all accepted scans, keyframes or not: for `duplicates`.
  std::span<const PosedScan> new_key_frames;  ///< In order.
  MapOutline outline{};                       ///< After the growth.
  bool drifts = false;  ///< The poses are those of lidar odometry, as MapInfo::drifts.
  /// Derived from the grown map, to be stored with it; null where that is done later.
  const MapContent* content = nullptr;
  const MapSketch* sketch = nullptr;  ///< Of `content`; null where there is none.
};

/// What PUT …/grid makes a map of, in one transaction.
struct FloorMap {
  const OccupancyGrid& grid;  ///< As drawn.
  KnownMap known{};           ///< The map that it is put in.
  MapOutline outline{};
};

/// Derived content as stored, with the revision it was made from.
struct StoredContent {
  std::uint64_t revision = 0;
  MapContent content;
};

/// What is known of a map without its content, and the revision that its sketch was made from.
struct SketchState {
  std::int64_t id = 0;
  std::string name;
  std::uint64_t revision = 0;
  bool has_content = false;           ///< It has bounds.
  std::uint64_t sketch_revision = 0;  ///< 0: no sketch is stored.
};

struct StoredSketch {
  std::int64_t map_id = 0;
  std::uint64_t revision = 0;  ///< Of the map that it was made from.
  MapSketch sketch;
};

/// Some sketches by map id.
struct SketchPage {
  std::vector<StoredSketch> sketches;  ///< Without those that are damaged.
  std::optional<std::int64_t> next{};  ///< `after` of the next page; none: that was the last one.
};

class MapStore {
 public:
  /// `database` is an open, migrated database; shared with the other stores of the same thread. Of
  /// each map at most `kept_revisions` former ones are kept (map_revisions.hpp).
  explicit MapStore(std::shared_ptr<Database> database,
                    std::size_t kept_revisions = kDefaultKeptRevisions);
  ~MapStore();
  MapStore(MapStore&&) noexcept;

  /// Maps by ascending name, after `after` (exclusive; empty: from the start), at most `limit`.
  [[nodiscard]] Result<std::vector<MapInfo>> list(std::string_view after, std::size_t limit);
  [[nodiscard]] Result<std::size_t> count();
  [[nodiscard]] Result<MapInfo> find(std::string_view name);  ///< kNotFound.

  /// Creates (true) or describes (false) a map. Parts that are nullopt stay as they are.
  /// A description alone does not change the revision; lidar and parameters do. kConflict when
  /// the map is not the one of `remake`.
  [[nodiscard]] Result<bool> put(std::string_view name, std::optional<std::string_view> description,
                                 std::optional<std::string_view> lidar_json,
                                 std::optional<std::string_view> parameters_json,
                                 std::string_view now,
                                 const std::optional<MapRemake>& remake = std::nullopt);
  /// kConflict when it is not the known one.
  [[nodiscard]] Result<void> remove(std::string_view name,
                                    const std::optional<KnownMap>& known = {});

  /// Which of `stamps` the map already holds, same order.
  [[nodiscard]] Result<std::vector<bool>> known_stamps(std::int64_t map_id,
                                                       std::span<const double> stamps);
  /// Adds to the map if it is still at `expected_revision` (else kConflict); returns the new entry.
  /// A stamp that the map already holds is kConflict too, and so is a map that was made from a
  /// occupancy map. Stamps without a keyframe change no content, so the revision stays.
  [[nodiscard]] Result<MapInfo> grow(std::int64_t map_id, std::uint64_t expected_revision,
                                     const MapGrowth& growth, std::string_view now);
  [[nodiscard]] Result<std::vector<PosedScan>> key_frames(std::int64_t map_id);

  /// Makes a map of an occupancy map, or puts the occupancy map in place of the one that a map was
  /// made from; returns the new entry. kConflict, and nothing changes, for a map that is not the
  /// known one or holds scans. The revision stays when it is the same occupancy map.
  [[nodiscard]] Result<MapInfo> put_floor_map(std::string_view name, const FloorMap& floor_map,
                                              std::string_view now);
  /// The map's whole source, in one snapshot.
  [[nodiscard]] Result<MapArchive> archive(std::string_view name);
  /// Makes a map of an archive, at its revision. kConflict when there is a map of that name.
  [[nodiscard]] Result<MapInfo> restore(std::string_view name, const MapArchive& archive,
                                        const MapOutline& outline, std::string_view now);
  /// The same with the id, dates, origin, features and bounds of `info`: a copy of another
  /// database's map.
  [[nodiscard]] Result<MapInfo> insert(MapInfo info, const MapArchive& archive);

  /// The occupancy map as it was put; kNotFound for a map that was not made from one.
  [[nodiscard]] Result<OccupancyGrid> floor_map(std::int64_t map_id);
  /// New poses for all keyframes, in their order, and what the map becomes with them; derived
  /// content becomes stale. The map no longer drifts. The revision stays when nothing differs.
  [[nodiscard]] Result<MapInfo> move_key_frames(std::int64_t map_id,
                                                std::uint64_t expected_revision,
                                                std::span<const Pose2> T_map_base_link,
                                                const MapOutline& outline, std::string_view now);

  /// The present revision, then those kept, newest first.
  [[nodiscard]] Result<std::vector<MapRevision>> revisions(std::string_view name);
  /// Of a kept revision. kNotFound, `field` "revision", with those that the map has.
  [[nodiscard]] Result<std::vector<std::uint8_t>> revision_archive(std::string_view name,
                                                                   std::uint64_t revision);
  /// Keeps one more, which is a copy from another database.
  [[nodiscard]] Result<void> insert_revision(std::int64_t map_id, const MapRevision& revision,
                                             std::span<const std::uint8_t> archive);
  /// Gives the map the content, lidar and parameters of an archive as its next revision. Its name
  /// and description stay. kConflict when it is not at `expected_revision`.
  [[nodiscard]] Result<MapInfo> roll_back(std::int64_t map_id, std::uint64_t expected_revision,
                                          const MapArchive& archive, const MapOutline& outline,
                                          std::string_view now);

  /// Derived content of the map if it is stored, of any revision; the caller compares revisions.
  [[nodiscard]] Result<std::optional<StoredContent>> content(std::int64_t map_id);
  /// Stores derived content made from `revision`; ignored (no error) when the map has moved on or
  /// is gone. Does not change the revision; updates feature_count.
  [[nodiscard]] Result<void> store_content(std::int64_t map_id, std::uint64_t revision,
                                           const MapContent& content);

  /// Of all maps, by ascending id.
  [[nodiscard]] Result<std::vector<SketchState>> sketch_states();
  /// Of maps with an id above `after`, at most `limit`.
  [[nodiscard]] Result<SketchPage> sketches(std::int64_t after, std::size_t limit);
  /// As store_content().
  [[nodiscard]] Result<void> store_sketch(std::int64_t map_id, std::uint64_t revision,
                                          const MapSketch& sketch);

 private:
  std::shared_ptr<Database> database_;
  std::size_t kept_revisions_;
};

}  // namespace cornerfix::storage

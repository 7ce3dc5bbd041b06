/// \file  The use cases on maps: describing, growing, moving, and having one ready to localize in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/localization_map.hpp>
#include <cornerfix/map_sketch.hpp>
#include <cornerfix/mapper.hpp>
#include <cornerfix/result.hpp>

#include "api/requests.hpp"
#include "server/map_cache.hpp"
#include "server/store_access.hpp"
#include "server/work_progress.hpp"
#include "storage/known_map.hpp"

namespace cornerfix::server {

/// RFC 3339 in UTC; handed in, so that tests need no wall clock.
using NowText = std::function<std::string()>;

struct MapLibraryLimits {
  std::size_t max_map_bytes = std::size_t{1} << 30U;  ///< Of loaded maps, those in use too.
  std::size_t max_mappers = 4;                        ///< Growing maps kept in memory.
};

/// What a mapping batch did, and where the map stands after it.
struct MapGrowthReport {
  std::size_t accepted = 0;    ///< Scans of the batch that were new.
  std::size_t duplicates = 0;  ///< Scans whose stamp the map held already.
  std::size_t key_frames = 0;  ///< Of the map.
  std::size_t features = 0;    ///< Of the map.
  std::uint64_t revision = 0;
};

/// What an occupancy map was made into.
struct FloorMapReport {
  bool created = false;  ///< The map did not exist before.
  storage::MapInfo info;
  std::vector<std::string> warnings;  ///< What the occupancy map's owner should know.
};

/// What a caller wants to change; nothing: any map. Where the map is another one the change is
/// kConflict, `field` "revision", unless it has been made already.
using ExpectedMap = std::optional<storage::KnownMap>;

/// What is known of a revision.
struct MapVersion {
  std::string digest;  ///< Empty when the revision is not kept.
  bool is_current = false;
};

/// Any threads may call; changes of one map happen one after the other. What a call acknowledged
/// is on disk, and a call that fails has changed nothing. Other processes may change the same file.
class MapLibrary {
 public:
  /// Called with the share done, in [0, 1]; the work is given up when it returns false.
  using Progress = std::function<bool(double)>;

  MapLibrary(std::shared_ptr<StoreAccess> stores, MapLibraryLimits limits, NowText now);
  ~MapLibrary();

  /// By ascending name, after `after` (empty: from the start).
  [[nodiscard]] Result<std::vector<storage::MapInfo>> list(std::string_view after,
                                                           std::size_t limit);
  [[nodiscard]] Result<storage::MapInfo> find(std::string_view name);
  [[nodiscard]] Result<std::size_t> count();
  /// True when the map was created. Parameters join those that the map has; kInvalidArgument when
  /// its grid would become too large with them.
  [[nodiscard]] Result<bool> put(std::string_view name, const api::PutMapRequest& request,
                                 const ExpectedMap& expected = {});
  [[nodiscard]] Result<void> remove(std::string_view name, const ExpectedMap& expected = {});

  /// The map's lidar for simulated scans; without `beams` of its own it has as many as the map's
  /// first scan of it. Nothing when the map was not given any.
  [[nodiscard]] Result<std::optional<api::Lidar>> lidar(const storage::MapInfo& info);

  /// kConflict when the map was made from scans without poses.
  [[nodiscard]] Result<MapGrowthReport> grow(std::string_view name,
                                             std::span<const PosedScan> scans,
                                             const ExpectedMap& expected = {});
  /// Scans of a run without poses, in its order: lidar odometry gives them, and load() takes
  /// their drift away. After a restart the run goes on at its last keyframe. kConflict when the
  /// map was made from scans at poses; kInvalidArgument when a new scan is not later than the
  /// keyframes.
  [[nodiscard]] Result<MapGrowthReport> grow(std::string_view name,
                                             std::span<const RobotScan> scans,
                                             const ExpectedMap& expected = {});

  /// The same with a whole run, whose map is made and stored with it: nothing is left for load().
  /// kUnavailable when `progress` gave up; then nothing has changed.
  [[nodiscard]] Result<MapGrowthReport> add_run(std::string_view name,
                                                std::span<const PosedScan> scans,
                                                const WorkProgress& progress,
                                                const ExpectedMap& expected = {});
  [[nodiscard]] Result<MapGrowthReport> add_run(std::string_view name,
                                                std::span<const RobotScan> scans,
                                                const WorkProgress& progress,
                                                const ExpectedMap& expected = {});

  /// Makes the map from a ROS occupancy map alone; a map made so before is made anew, in its frame
  /// and with its parameters. kConflict for a map that holds scans, kTooLarge for a long yaml.
  /// kUnavailable when `progress` gave up.
  [[nodiscard]] Result<FloorMapReport> put_floor_map(std::string_view name, std::string_view yaml,
                                                     std::span<const std::byte> image,
                                                     const WorkProgress& progress = {},
                                                     const ExpectedMap& expected = {});

  /// The whole map as one SQLite file.
  [[nodiscard]] Result<std::vector<std::uint8_t>> archive(std::string_view name);
  /// The same of a revision. kNotFound, `field` "revision", when it is not kept.
  [[nodiscard]] Result<std::vector<std::uint8_t>> archive(std::string_view name,
                                                          std::uint64_t revision);
  /// Makes a map of an archive, which anyone may have made: all of it is checked before anything is
  /// stored. kConflict when there is a map of that name.
  /// kUnavailable when `progress` gave up.
  [[nodiscard]] Result<storage::MapInfo> restore(std::string_view name,
                                                 std::span<const std::uint8_t> bytes,
                                                 const WorkProgress& progress = {});

  /// The present revision, then the former ones that are kept, newest first.
  [[nodiscard]] Result<std::vector<storage::MapRevision>> revisions(std::string_view name);
  /// kNotFound when there is no such map.
  [[nodiscard]] Result<MapVersion> version(std::string_view name, std::uint64_t revision);
  /// The content, lidar and parameters of a kept revision become those of a new one; the present
  /// revision stays as it is. kNotFound, `field` "revision", when it is not kept.
  [[nodiscard]] Result<storage::MapInfo> roll_back(std::string_view name, std::uint64_t revision,
                                                   const ExpectedMap& expected = {});

  /// The map's grid as it is to be shown: the occupancy map as it was put, or what scans made.
  /// Empty when the map has neither.
  [[nodiscard]] Result<OccupancyGrid> grid(const storage::MapInfo& info);

  /// Moves every keyframe to the pose of its stamp (nearest within 1 ms). kInvalidArgument, with
  /// the stamps that are missing, when some have none, and when the map would spread beyond what
  /// its grid can hold.
  [[nodiscard]] Result<storage::MapInfo> set_trajectory(std::string_view name,
                                                        std::span<const api::StampedPose> poses,
                                                        const ExpectedMap& expected = {});

  /// The newest revision of a map, from memory, from the store, or made again and then stored. The
  /// trajectory of a map that drifts is then optimised, with calls of `progress`.
  [[nodiscard]] Result<LocalizationMapPtr> load(std::string_view name,
                                                const Progress& progress = {});
  /// The same, when the caller knows that `info` is current: id, name and revision are used.
  /// kNotFound when another map has the name now.
  [[nodiscard]] Result<LocalizationMapPtr> load(const storage::MapInfo& info,
                                                const Progress& progress = {});

  /// Makes the sketch of a map and stores it. kNotFound when the map is not at the revision of
  /// `info`.
  [[nodiscard]] Result<MapSketch> make_sketch(const storage::MapInfo& info);

  [[nodiscard]] MapCacheUse cache_use() { return cache_.use(); }
  /// As MapCache::make_room().
  bool make_room() { return cache_.make_room(); }
  /// What this revision needed in memory when it was last loaded; 0 when that is not known.
  [[nodiscard]] std::size_t known_bytes(const storage::MapInfo& info) {
    return cache_.known_bytes({info.id, info.revision});
  }

 private:
  struct GrowingMap;
  struct GrownMap;

  [[nodiscard]] std::shared_ptr<GrowingMap> growing(std::int64_t map_id);
  [[nodiscard]] Result<void> rebuild(GrowingMap& growing, const storage::MapInfo& info);
  /// Either kind of scans.
  template <typename Scan>
  [[nodiscard]] Result<MapGrowthReport> grow_once(std::string_view name,
                                                  std::span<const Scan> scans,
                                                  const ExpectedMap& expected);
  template <typename Scan>
  [[nodiscard]] Result<MapGrowthReport> add_run_once(std::string_view name,
                                                     std::span<const Scan> scans,
                                                     const WorkProgress& progress,
                                                     const ExpectedMap& expected);
  /// With `progress` the run is over, and its content is stored with it.
  template <typename Scan>
  [[nodiscard]] Result<MapGrowthReport> grow_by(GrowingMap& growing, const storage::MapInfo& info,
                                                std::span<const Scan> scans,
                                                const ExpectedMap& expected,
                                                const WorkProgress& progress);
  /// \param content  Stored with the growth, with its sketch; null where that is done later.
  [[nodiscard]] Result<storage::MapInfo> store_growth(const GrownMap& grown,
                                                      const storage::MapInfo& before, bool drifts,
                                                      const MapContent* content = nullptr);
  [[nodiscard]] Result<storage::MapInfo> store_with_content(const GrownMap& grown,
                                                            const storage::MapInfo& before,
                                                            bool drifts,
                                                            const WorkProgress& progress);
  [[nodiscard]] Result<bool> put_once(std::string_view name, const api::PutMapRequest& request,
                                      const ExpectedMap& expected);
  [[nodiscard]] Result<void> remove_once(std::string_view name, const ExpectedMap& expected);
  [[nodiscard]] Result<FloorMapReport> put_floor_map_once(std::string_view name,
                                                          const OccupancyGrid& floor_map,
                                                          const WorkProgress& progress,
                                                          const ExpectedMap& expected);
  /// \param before  The entry as it is; revision 0 when there is none.
  [[nodiscard]] Result<FloorMapReport> make_from_floor_map(std::string_view name,
                                                           const OccupancyGrid& floor_map,
                                                           const storage::MapInfo& before,
                                                           const WorkProgress& progress);
  [[nodiscard]] Result<bool> store_entry(std::string_view name, const api::PutMapRequest& request,
                                         const std::optional<storage::MapRemake>& remake = {});
  [[nodiscard]] Result<storage::MapOutline> outline_with(const storage::MapInfo& info);
  [[nodiscard]] Result<storage::MapInfo> set_trajectory_once(
      std::string_view name, std::span<const api::StampedPose> poses, const ExpectedMap& expected);
  [[nodiscard]] Result<storage::MapInfo> roll_back_once(std::string_view name,
                                                        std::uint64_t revision,
                                                        const ExpectedMap& expected);
  [[nodiscard]] Result<MapContent> content_of(GrowingMap& growing, const storage::MapInfo& info,
                                              const Progress& progress);
  /// With its sketch.
  [[nodiscard]] Result<void> store_content(const storage::MapInfo& info, const MapContent& content);
  [[nodiscard]] Result<void> store_sketch(const storage::MapInfo& info, const MapSketch& sketch);
  [[nodiscard]] Result<MapContent> content_of_floor_map(const storage::MapInfo& info);
  [[nodiscard]] Result<MapContent> content_of_key_frames(GrowingMap& growing,
                                                         const storage::MapInfo& info,
                                                         const Progress& progress);

  std::shared_ptr<StoreAccess> stores_;
  std::size_t max_mappers_;
  NowText now_;
  MapCache cache_;

  std::mutex growing_mutex_;
  std::list<std::shared_ptr<GrowingMap>> growing_;  ///< Last used first.
};

}  // namespace cornerfix::server

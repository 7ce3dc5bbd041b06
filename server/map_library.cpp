#include "server/map_library.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <unordered_set>

#include <cornerfix/grid_mapping.hpp>
#include <cornerfix/lidar_odometry.hpp>
#include <cornerfix/map_image.hpp>
#include <cornerfix/trajectory_optimizer.hpp>

namespace cornerfix::server {

using storage::MapInfo;
using storage::MapStore;

namespace {

constexpr int kMaxRevisionAttempts = 3;
constexpr double kStampToleranceS = 1e-3;
constexpr std::size_t kMaxStampsTold = 20;

/// Whether another process came in between, so that trying again on its result makes sense.
bool is_worth_another_try(const Error& error) { return error.code == ErrorCode::kConflict; }

template <typename Change>
auto retrying(Change change) {
  for (int attempt = 1;; ++attempt) {
    auto result = change();
    if (result || attempt == kMaxRevisionAttempts || !is_worth_another_try(result.error()))
      return result;
  }
}

/// The box around a grid, however it is turned.
Bounds bounds_of(const OccupancyGrid& grid) {
  const Point2 first = grid.T_map_grid.translation();
  Bounds bounds{first, first};
  for (const int column : {0, grid.width}) {
    for (const int row : {0, grid.height}) {
      const Point2 corner = grid.T_map_grid * (grid.resolution * Point2(column, row));
      bounds.extend({corner, corner});
    }
  }
  return bounds;
}

Error bad_archive(std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message), "/archive"};
}

void set_bounds(MapInfo& info, const Bounds& bounds) {
  info.has_bounds = true;
  info.min_x = bounds.min.x();
  info.min_y = bounds.min.y();
  info.max_x = bounds.max.x();
  info.max_y = bounds.max.y();
}

storage::MapOutline outline_from(std::size_t features, const Bounds& bounds) {
  return {.feature_count = features,
          .min_x = bounds.min.x(),
          .min_y = bounds.min.y(),
          .max_x = bounds.max.x(),
          .max_y = bounds.max.y()};
}

storage::MapOutline outline_from(const Mapper& mapper) {
  return outline_from(mapper.feature_count(), mapper.bounds().value_or(Bounds{}));
}

/// A mapper that holds these key frames, or why its grid could not.
Result<Mapper> mapper_of(std::vector<PosedScan> key_frames, const MapperParams& params) {
  Mapper mapper(params);
  for (PosedScan& key_frame : key_frames) {
    if (auto error = mapper.reject(key_frame)) return std::move(*error);
    mapper.add(std::move(key_frame));
  }
  return mapper;
}

/// What is derived for the entry of an archive's map.
Result<MapInfo> describe(const storage::MapArchive& archive) {
  const MapperParams params = api::mapper_params_from_json(archive.parameters_json);
  MapInfo info;
  if (archive.floor_map) {
    const auto made = map_from_grid(*archive.floor_map, params);
    if (!made) return bad_archive(made.error().message);
    info.feature_count = made->content.features.size();
    set_bounds(info, bounds_of(made->content.grid));
    return info;
  }
  const auto mapper = mapper_of(archive.key_frames, params);
  if (!mapper) return bad_archive(mapper.error().message);
  info.feature_count = mapper->feature_count();
  if (mapper->bounds()) set_bounds(info, *mapper->bounds());
  return info;
}

/// The scans that the map does not hold and that are not earlier in the batch.
template <typename Scan>
std::vector<const Scan*> new_scans(std::span<const Scan> scans, const std::vector<bool>& known) {
  std::vector<const Scan*> fresh;
  std::unordered_set<double> stamps;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (!known[i] && stamps.insert(scans[i].scan.stamp).second) fresh.push_back(&scans[i]);
  }
  return fresh;
}

bool is_scan_of(const LaserScan& scan, const api::Lidar& lidar) {
  return scan.angle_min == lidar.angle_min && scan.angle_increment == lidar.angle_increment &&
         scan.range_min == lidar.range_min && scan.range_max == lidar.range_max;
}

/// Why a map with key frames cannot take scans that come with poses, or without.
std::optional<Error> mixed(const MapInfo& map, bool scans_have_poses) {
  if (map.key_frame_count == 0 || map.drifts != scans_have_poses) return std::nullopt;
  return Error{ErrorCode::kConflict,
               map.drifts
                   ? "the map is made from scans without poses: these have poses. Give the "
                     "map an optimised trajectory first, or another name"
                   : "the map is made from scans at poses: these have none. Give them poses in its "
                     "frame, as a robot that is localized in it has, or another map",
               "/scans"};
}

/// A scan of a drive must come after what is there of it.
template <typename Scan>
std::optional<Error> too_late(std::span<const Scan* const> fresh, const Mapper& mapper,
                              const Scan* first_of_batch) {
  if (fresh.empty() || mapper.key_frames().empty()) return std::nullopt;
  const double last = mapper.key_frames().back().scan.stamp;
  const auto late =
      std::ranges::find_if(fresh, [last](const Scan* scan) { return scan->scan.stamp <= last; });
  if (late == fresh.end()) return std::nullopt;
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("must be later than the last key frame's {}, since scans without pose "
                           "are one drive",
                           last),
               "/scans/" + std::to_string(*late - first_of_batch) + "/stamp"};
}

Error at_scan(Error error, std::ptrdiff_t index) {
  error.field = "/scans/" + std::to_string(index);
  return error;
}

MapperParams mapper_params(const MapInfo& info) {
  return api::mapper_params_from_json(info.parameters_json);
}

/// NaN for every beam without return, whichever way it was told: the digest is the same then.
void unify_no_returns(LaserScan& scan) {
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.has_return(beam)) scan.ranges[beam] = std::numeric_limits<float>::quiet_NaN();
  }
}

PosedScan posed_by(LidarOdometry& /*odometry*/, const PosedScan& scan) { return scan; }

PosedScan posed_by(LidarOdometry& odometry, const RobotScan& scan) {
  return {scan.scan, scan.T_base_link_laser, odometry.process(scan)};
}

std::vector<PosedScan> moved_to(std::span<const Pose2> T_map_base_link,
                                std::vector<PosedScan> key_frames) {
  for (std::size_t i = 0; i < key_frames.size(); ++i) {
    key_frames[i].T_map_base_link = T_map_base_link[i];
  }
  return key_frames;
}

/// That a map cannot be made of what is stored, so that the asker can do nothing about it but
/// change the map.
Error too_large_now(const Error& error) { return {ErrorCode::kConflict, error.message, ""}; }

/// What the key frames of a drive show once its drift has been taken away.
Result<MapContent> build_without_drift(const Mapper& drifting, const MapperParams& params,
                                       const MapLibrary::Progress& progress) {
  const auto optimized = optimize_trajectory(drifting.key_frames(), progress);
  if (!optimized) return optimized.error();
  const auto mapper =
      mapper_of(moved_to(optimized->T_map_base_link, drifting.key_frames()), params);
  if (!mapper) return too_large_now(mapper.error());
  return mapper->build();
}

/// An error in the files of a floor map, as one in the form that they came in. Those that may be
/// read but are wrong are keys of the yaml.
Error at_form(Error error) {
  error.field = (error.code == ErrorCode::kInvalidArgument ? "/yaml/" : "/") + error.field;
  return error;
}

/// An error in a part of the request.
Error at_part(Error error) {
  error.field = "/" + error.field;
  return error;
}

Error no_key_frames() {
  return {ErrorCode::kConflict,
          "the map was made from a floor map: it has no key frames that could move", "/map"};
}

const api::StampedPose* nearest(const std::vector<api::StampedPose>& poses, double stamp) {
  const auto after = std::ranges::lower_bound(poses, stamp, {}, &api::StampedPose::stamp);
  const api::StampedPose* best = after == poses.end() ? nullptr : &*after;
  if (after != poses.begin()) {
    const api::StampedPose* before = &*std::prev(after);
    if (best == nullptr || stamp - before->stamp < best->stamp - stamp) best = before;
  }
  const bool is_near = best != nullptr && std::abs(best->stamp - stamp) <= kStampToleranceS;
  return is_near ? best : nullptr;
}

Error uncovered_key_frames(const std::vector<double>& missing, std::size_t key_frames) {
  std::string message = "no pose within 1 ms of " + std::to_string(missing.size()) + " of " +
                        std::to_string(key_frames) + " key frames, at stamps ";
  const std::size_t told = std::min(missing.size(), kMaxStampsTold);
  for (std::size_t i = 0; i < told; ++i) {
    message += fmt::format("{}{}", i == 0 ? "" : ", ", missing[i]);
  }
  if (told < missing.size()) message += ", …";
  return {ErrorCode::kInvalidArgument, message, "/poses"};
}

Result<std::vector<Pose2>> poses_of(const std::vector<PosedScan>& key_frames,
                                    std::span<const api::StampedPose> given) {
  std::vector<api::StampedPose> poses(given.begin(), given.end());
  std::ranges::sort(poses, {}, &api::StampedPose::stamp);
  std::vector<Pose2> moved;
  std::vector<double> missing;
  for (const PosedScan& key_frame : key_frames) {
    const api::StampedPose* pose = nearest(poses, key_frame.scan.stamp);
    if (pose != nullptr) {
      moved.push_back(pose->T_map_base_link);
    } else {
      missing.push_back(key_frame.scan.stamp);
    }
  }
  if (!missing.empty()) return uncovered_key_frames(missing, key_frames.size());
  return moved;
}

}  // namespace

/// A map being changed or made ready, one thread at a time.
struct MapLibrary::GrowingMap {
  explicit GrowingMap(std::int64_t id) : map_id(id) {}

  const std::int64_t map_id;
  std::mutex mutex;
  std::optional<Mapper> mapper;           ///< Holds the key frames of `revision`.
  std::optional<LidarOdometry> odometry;  ///< At the last scan of a drive without poses.
  std::uint64_t revision = 0;

  [[nodiscard]] bool holds(const MapInfo& info) const {
    return mapper.has_value() && revision == info.revision;
  }

  /// What is known of the map in memory may be ahead of the store, or behind it.
  void forget() {
    mapper.reset();
    odometry.reset();
  }
};

MapLibrary::MapLibrary(std::shared_ptr<StoreAccess> stores, MapLibraryLimits limits, NowText now)
    : stores_(std::move(stores)), limits_(limits), now_(std::move(now)) {}

MapLibrary::~MapLibrary() = default;

Result<std::vector<MapInfo>> MapLibrary::list(std::string_view after, std::size_t limit) {
  return stores_->with_map_entries([&](MapStore& maps) { return maps.list(after, limit); });
}

Result<MapInfo> MapLibrary::find(std::string_view name) {
  return stores_->with_map_entries([&](MapStore& maps) { return maps.find(name); });
}

Result<bool> MapLibrary::put(std::string_view name, const api::PutMapRequest& request) {
  return retrying([&] { return put_once(name, request); });
}

Result<bool> MapLibrary::put_once(std::string_view name, const api::PutMapRequest& request) {
  if (!request.parameters_json) return store_entry(name, request);
  auto found = find(name);
  if (!found && found.error().code != ErrorCode::kNotFound) return found.error();
  if (!found) return store_entry(name, request, storage::MapRemake{.expected_revision = 0});
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The change before this one may just have come.
  if (!found) return found.error();
  const auto merged = api::merged_parameters(found->parameters_json, *request.parameters_json);
  if (!merged) return merged.error();
  MapInfo remade = *found;
  remade.parameters_json = *merged;
  const auto outline = outline_of(remade);
  if (!outline) return outline.error();
  return store_entry(name, {request.description, request.lidar_json, *merged},
                     storage::MapRemake{.expected_revision = found->revision, .outline = *outline});
}

Result<bool> MapLibrary::store_entry(std::string_view name, const api::PutMapRequest& request,
                                     const std::optional<storage::MapRemake>& remake) {
  return stores_->with_maps([&](MapStore& maps) {
    return maps.put(name, request.description, request.lidar_json, request.parameters_json, now_(),
                    remake);
  });
}

/// Of what is made of the map's source with the parameters in `info`.
Result<storage::MapOutline> MapLibrary::outline_of(const MapInfo& info) {
  if (info.has_floor_map) {
    const auto content = content_of_floor_map(info);
    if (!content) return content.error();
    return outline_from(content->features.size(), bounds_of(content->grid));
  }
  auto key_frames = stores_->with_maps([&](MapStore& maps) { return maps.key_frames(info.id); });
  if (!key_frames) return key_frames.error();
  const auto mapper = mapper_of(std::move(*key_frames), mapper_params(info));
  if (!mapper) {
    return Error{ErrorCode::kInvalidArgument, mapper.error().message,
                 "/parameters/grid/resolution_m"};
  }
  return outline_from(*mapper);
}

Result<void> MapLibrary::remove(std::string_view name) {
  return stores_->with_maps([&](MapStore& maps) { return maps.remove(name); });
}

Result<std::optional<api::Lidar>> MapLibrary::lidar(const MapInfo& info) {
  std::optional<api::Lidar> lidar = api::lidar_from_json(info.lidar_json);
  if (!lidar || lidar->beams || info.key_frame_count == 0) return lidar;
  const auto growing = this->growing(info.id);
  const std::lock_guard lock(growing->mutex);
  if (auto rebuilt = rebuild(*growing, info); !rebuilt) return rebuilt.error();
  for (const PosedScan& key_frame : growing->mapper->key_frames()) {
    if (!is_scan_of(key_frame.scan, *lidar)) continue;
    lidar->beams = key_frame.scan.ranges.size();
    break;
  }
  return lidar;
}

Result<MapGrowthReport> MapLibrary::grow(std::string_view name, std::span<const PosedScan> scans) {
  return retrying([&] { return grow_once(name, scans); });
}

Result<MapGrowthReport> MapLibrary::grow(std::string_view name, std::span<const RobotScan> scans) {
  return retrying([&] { return grow_once(name, scans); });
}

template <typename Scan>
Result<MapGrowthReport> MapLibrary::grow_once(std::string_view name, std::span<const Scan> scans) {
  constexpr bool kHavePoses = std::is_same_v<Scan, PosedScan>;
  auto found = find(name);
  if (!found) return found.error();
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The batch before this one may just have changed it.
  if (!found) return found.error();
  if (auto error = mixed(*found, kHavePoses)) return *error;
  if (auto rebuilt = rebuild(*growing, *found); !rebuilt) return rebuilt.error();

  std::vector<double> stamps;
  for (const Scan& scan : scans) stamps.push_back(scan.scan.stamp);
  const auto known =
      stores_->with_maps([&](MapStore& maps) { return maps.known_stamps(found->id, stamps); });
  if (!known) return known.error();
  const auto fresh = new_scans(scans, *known);

  MapGrowthReport report{.accepted = fresh.size(),
                         .duplicates = scans.size() - fresh.size(),
                         .key_frames = found->key_frame_count,
                         .features = found->feature_count,
                         .revision = found->revision};
  if (fresh.empty()) return report;

  // From here on what is in memory is ahead of the store, until the store has the growth too.
  Mapper mapper = std::move(*growing->mapper);
  LidarOdometry odometry;
  if constexpr (!kHavePoses) {
    if (auto error = too_late<Scan>(fresh, mapper, scans.data())) {
      growing->mapper = std::move(mapper);
      return *error;
    }
    if (growing->odometry) {
      odometry = std::move(*growing->odometry);
    } else {
      odometry.resume(mapper.key_frames());
    }
  }
  growing->forget();
  std::vector<double> new_stamps;
  std::vector<PosedScan> new_key_frames;
  for (const Scan* scan : fresh) {
    new_stamps.push_back(scan->scan.stamp);
    PosedScan posed = posed_by(odometry, *scan);
    unify_no_returns(posed.scan);
    if (!mapper.is_key_frame(posed)) continue;
    if (auto error = mapper.reject(posed)) return at_scan(*error, scan - scans.data());
    mapper.add(posed);
    new_key_frames.push_back(std::move(posed));
  }
  const Bounds bounds = mapper.bounds().value_or(Bounds{});
  const storage::MapGrowth growth{.stamps = new_stamps,
                                  .new_key_frames = new_key_frames,
                                  .feature_count = mapper.feature_count(),
                                  .min_x = bounds.min.x(),
                                  .min_y = bounds.min.y(),
                                  .max_x = bounds.max.x(),
                                  .max_y = bounds.max.y(),
                                  .drifts = !kHavePoses};
  const auto grown = stores_->with_maps(
      [&](MapStore& maps) { return maps.grow(found->id, found->revision, growth, now_()); });
  if (!grown) return grown.error();
  growing->mapper = std::move(mapper);
  if constexpr (!kHavePoses) growing->odometry = std::move(odometry);
  growing->revision = grown->revision;
  report.key_frames = grown->key_frame_count;
  report.features = grown->feature_count;
  report.revision = grown->revision;
  return report;
}

Result<MapInfo> MapLibrary::set_trajectory(std::string_view name,
                                           std::span<const api::StampedPose> poses) {
  return retrying([&] { return set_trajectory_once(name, poses); });
}

Result<MapInfo> MapLibrary::set_trajectory_once(std::string_view name,
                                                std::span<const api::StampedPose> poses) {
  auto found = find(name);
  if (!found) return found.error();
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The change before this one may just have come.
  if (!found) return found.error();
  if (found->has_floor_map) return no_key_frames();
  auto key_frames = stores_->with_maps([&](MapStore& maps) { return maps.key_frames(found->id); });
  if (!key_frames) return key_frames.error();
  const auto moved = poses_of(*key_frames, poses);
  if (!moved) return moved.error();
  const auto mapper = mapper_of(moved_to(*moved, std::move(*key_frames)), mapper_params(*found));
  if (!mapper) return Error{ErrorCode::kInvalidArgument, mapper.error().message, "/poses"};
  return stores_->with_maps([&](MapStore& maps) {
    return maps.move_key_frames(found->id, found->revision, *moved, outline_from(*mapper), now_());
  });
}

Result<FloorMapReport> MapLibrary::put_floor_map(std::string_view name, std::string_view yaml,
                                                 std::span<const std::byte> image) {
  const auto floor_map = parse_map(yaml, image);
  if (!floor_map) return at_form(floor_map.error());
  const auto found = find(name);
  if (!found && found.error().code != ErrorCode::kNotFound) return found.error();
  auto made = map_from_grid(
      *floor_map, api::mapper_params_from_json(found ? found->parameters_json : std::string()));
  if (!made) return at_part(made.error());
  const Bounds bounds = bounds_of(made->content.grid);
  const storage::FloorMap stored{.grid = *floor_map,
                                 .feature_count = made->content.features.size(),
                                 .min_x = bounds.min.x(),
                                 .min_y = bounds.min.y(),
                                 .max_x = bounds.max.x(),
                                 .max_y = bounds.max.y()};
  const auto created =
      stores_->with_maps([&](MapStore& maps) { return maps.put_floor_map(name, stored, now_()); });
  if (!created) return created.error();
  auto info = find(name);
  if (!info) return info.error();
  const auto kept = stores_->with_maps(
      [&](MapStore& maps) { return maps.store_content(info->id, info->revision, made->content); });
  if (!kept) return kept.error();
  FloorMapReport report{*created, std::move(*info), std::move(made->warnings)};
  if (auto advice = threshold_advice(yaml, image)) report.warnings.push_back(std::move(*advice));
  return report;
}

Result<std::vector<std::uint8_t>> MapLibrary::archive(std::string_view name) {
  const auto archive = stores_->with_maps([&](MapStore& maps) { return maps.archive(name); });
  if (!archive) return archive.error();
  return storage::encode_archive(*archive);
}

Result<MapInfo> MapLibrary::restore(std::string_view name, std::span<const std::uint8_t> bytes) {
  const auto archive = storage::decode_archive(bytes);
  if (!archive) return at_part(archive.error());
  if (!api::is_put_map_request(archive->description, archive->lidar_json, archive->parameters_json))
    return bad_archive("its description, lidar or parameters are not as a server writes them");
  const auto info = describe(*archive);
  if (!info) return info.error();
  return stores_->with_maps(
      [&](MapStore& maps) { return maps.restore(name, *archive, *info, now_()); });
}

Result<OccupancyGrid> MapLibrary::grid(const MapInfo& info) {
  if (info.has_floor_map)
    return stores_->with_maps([&](MapStore& maps) { return maps.floor_map(info.id); });
  const auto map = load(info);
  if (!map) return map.error();
  return (*map)->grid();
}

Result<LocalizationMapPtr> MapLibrary::load(std::string_view name, const Progress& progress) {
  const auto info = find(name);
  if (!info) return info.error();
  return load(*info, progress);
}

Result<LocalizationMapPtr> MapLibrary::load(const MapInfo& info, const Progress& progress) {
  if (auto map = cached({info.id, info.revision})) return map;
  const auto growing = this->growing(info.id);
  const std::lock_guard lock(growing->mutex);
  const auto current = find(info.name);
  if (!current) return current.error();
  const Key key{current->id, current->revision};
  if (auto map = cached(key)) return map;
  auto content = content_of(*growing, *current, progress);
  if (!content) return content.error();
  const auto map = std::make_shared<const LocalizationMap>(current->name, current->revision,
                                                           std::move(*content));
  remember(key, map);
  return LocalizationMapPtr(map);
}

Result<MapContent> MapLibrary::content_of(GrowingMap& growing, const MapInfo& info,
                                          const Progress& progress) {
  auto stored = stores_->with_maps([&](MapStore& maps) { return maps.content(info.id); });
  if (!stored) return stored.error();
  if (stored->has_value() && (*stored)->revision == info.revision) {
    return std::move((*stored)->content);
  }
  auto made = info.has_floor_map ? content_of_floor_map(info)
                                 : content_of_key_frames(growing, info, progress);
  if (!made) return made;
  MapContent& content = *made;
  const auto kept = stores_->with_maps(
      [&](MapStore& maps) { return maps.store_content(info.id, info.revision, content); });
  if (!kept) return kept.error();
  return made;
}

Result<MapContent> MapLibrary::content_of_floor_map(const MapInfo& info) {
  const auto floor_map =
      stores_->with_maps([&](MapStore& maps) { return maps.floor_map(info.id); });
  if (!floor_map) return floor_map.error();
  auto made = map_from_grid(*floor_map, mapper_params(info));
  if (!made) return made.error();
  return std::move(made->content);
}

Result<MapContent> MapLibrary::content_of_key_frames(GrowingMap& growing, const MapInfo& info,
                                                     const Progress& progress) {
  const bool was_growing = growing.mapper.has_value();
  if (auto rebuilt = rebuild(growing, info); !rebuilt) return rebuilt.error();
  auto built = info.drifts ? build_without_drift(*growing.mapper, mapper_params(info), progress)
                           : Result<MapContent>(growing.mapper->build());
  if (!was_growing) growing.forget();  // Its key frames are needed for growing only.
  return built;
}

Result<void> MapLibrary::rebuild(GrowingMap& growing, const MapInfo& info) {
  if (growing.holds(info)) return {};
  growing.forget();
  auto key_frames = stores_->with_maps([&](MapStore& maps) { return maps.key_frames(info.id); });
  if (!key_frames) return key_frames.error();
  auto mapper = mapper_of(std::move(*key_frames), mapper_params(info));
  if (!mapper) return too_large_now(mapper.error());
  growing.mapper = std::move(*mapper);
  growing.revision = info.revision;
  return {};
}

std::shared_ptr<MapLibrary::GrowingMap> MapLibrary::growing(std::int64_t map_id) {
  const std::lock_guard lock(growing_mutex_);
  const auto found =
      std::ranges::find(growing_, map_id, [](const auto& entry) { return entry->map_id; });
  if (found != growing_.end()) {
    growing_.splice(growing_.begin(), growing_, found);
    return growing_.front();
  }
  // One in use stays, so that there are never two of the same map.
  for (auto last = growing_.end(); growing_.size() >= limits_.max_mappers;) {
    if (last == growing_.begin()) break;
    --last;
    if (last->use_count() == 1) last = growing_.erase(last);
  }
  return growing_.emplace_front(std::make_shared<GrowingMap>(map_id));
}

LocalizationMapPtr MapLibrary::cached(const Key& key) {
  const std::lock_guard lock(cache_mutex_);
  const auto found = std::ranges::find(cache_, key, &CachedMap::key);
  if (found == cache_.end()) return nullptr;
  cache_.splice(cache_.begin(), cache_, found);
  return cache_.front().map;
}

void MapLibrary::remember(const Key& key, const LocalizationMapPtr& map) {
  const std::lock_guard lock(cache_mutex_);
  cache_.remove_if([&](const CachedMap& old) { return old.key.first == key.first; });
  cache_.push_front({key, map, map->bytes()});
  std::size_t bytes = 0;
  for (auto entry = cache_.begin(); entry != cache_.end();) {
    bytes += entry->bytes;
    const bool is_first = entry == cache_.begin();
    entry = bytes > limits_.max_map_bytes && !is_first ? cache_.erase(entry) : std::next(entry);
  }
}

MapCacheUse MapLibrary::cache_use() {
  const std::lock_guard lock(cache_mutex_);
  MapCacheUse use{.maps = cache_.size()};
  for (const CachedMap& entry : cache_) use.bytes += entry.bytes;
  return use;
}

}  // namespace cornerfix::server

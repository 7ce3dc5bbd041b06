#include "server/map_library.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <type_traits>

#include <cornerfix/mapper.hpp>

#include "server/growing_map.hpp"
#include "server/map_outline.hpp"
#include "server/mapping_batch.hpp"
#include "server/trajectory_poses.hpp"

namespace cornerfix::server {

using storage::MapInfo;
using storage::MapStore;

namespace {

bool is_scan_of(const LaserScan& scan, const api::Lidar& lidar) {
  return scan.angle_min == lidar.angle_min && scan.angle_increment == lidar.angle_increment &&
         scan.range_min == lidar.range_min && scan.range_max == lidar.range_max;
}

Error at_scan(Error error, std::ptrdiff_t index) {
  error.field = "/scans/" + std::to_string(index);
  return error;
}

Error bad_archive(std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message), "/archive"};
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

/// What the keyframes of a run show once its drift has been taken away.
Result<MapContent> build_without_drift(const Mapper& drifting, const MapperParams& params,
                                       const MapLibrary::Progress& progress) {
  const auto optimized = optimize_trajectory(drifting.key_frames(), progress);
  if (!optimized) return optimized.error();
  const auto mapper =
      mapper_of(moved_to(optimized->T_map_base_link, drifting.key_frames()), params);
  if (!mapper) return too_large_now(mapper.error());
  return mapper->build();
}

Error another_map(const std::string& name) {
  return {ErrorCode::kNotFound, "the map " + name + " was changed or replaced", ""};
}

Error no_key_frames() {
  return {ErrorCode::kConflict,
          "the map was made from a floor map: it has no key frames that could move", "/map"};
}

/// Those that the map does not hold yet.
template <typename Scan>
Result<std::vector<const Scan*>> fresh_scans(StoreAccess& stores, std::int64_t map,
                                             std::span<const Scan> scans) {
  std::vector<double> stamps;
  for (const Scan& scan : scans) stamps.push_back(scan.scan.stamp);
  const auto known =
      stores.with_maps([&](MapStore& maps) { return maps.known_stamps(map, stamps); });
  if (!known) return known.error();
  return new_scans(scans, *known);
}

/// The odometry that goes on where the keyframes end.
LidarOdometry continued(std::optional<LidarOdometry>& odometry, const Mapper& mapper) {
  if (odometry) return std::move(*odometry);
  LidarOdometry resumed;
  resumed.resume(mapper.key_frames());
  return resumed;
}

}  // namespace

MapLibrary::MapLibrary(std::shared_ptr<StoreAccess> stores, MapLibraryLimits limits, NowText now)
    : stores_(std::move(stores)),
      max_mappers_(limits.max_mappers),
      now_(std::move(now)),
      cache_(limits.max_map_bytes) {}

MapLibrary::~MapLibrary() = default;

Result<std::vector<MapInfo>> MapLibrary::list(std::string_view after, std::size_t limit) {
  return stores_->with_map_entries([&](MapStore& maps) { return maps.list(after, limit); });
}

Result<MapInfo> MapLibrary::find(std::string_view name) {
  return stores_->with_map_entries([&](MapStore& maps) { return maps.find(name); });
}

Result<std::size_t> MapLibrary::count() {
  return stores_->with_maps([](MapStore& maps) { return maps.count(); });
}

Result<bool> MapLibrary::put(std::string_view name, const api::PutMapRequest& request,
                             const ExpectedRevision& expected) {
  return retrying([&] { return put_once(name, request, expected); });
}

Result<bool> MapLibrary::put_once(std::string_view name, const api::PutMapRequest& request,
                                  const ExpectedRevision& expected) {
  if (!request.parameters_json && !expected) return store_entry(name, request);
  auto found = find(name);
  if (!found && found.error().code != ErrorCode::kNotFound) return found.error();
  if (!found) {
    if (const auto checked = check_revision(0, expected); !checked) return checked.error();
    return store_entry(name, request, storage::MapRemake{.expected_revision = 0});
  }
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The change before this one may just have come.
  if (!found) return found.error();
  if (const auto checked = check_revision(found->revision, expected); !checked)
    return checked.error();
  if (!request.parameters_json) {
    return store_entry(name, request,
                       storage::MapRemake{found->revision, {found->feature_count, found->bounds}});
  }
  const auto merged = api::merged_parameters(found->parameters_json, *request.parameters_json);
  if (!merged) return merged.error();
  MapInfo remade = *found;
  remade.parameters_json = *merged;
  const auto outline = outline_with(remade);
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
Result<storage::MapOutline> MapLibrary::outline_with(const MapInfo& info) {
  if (info.has_floor_map) {
    const auto content = content_of_floor_map(info);
    if (!content) return content.error();
    return outline_of(*content);
  }
  auto key_frames = stores_->with_maps([&](MapStore& maps) { return maps.key_frames(info.id); });
  if (!key_frames) return key_frames.error();
  const auto mapper = mapper_of(std::move(*key_frames), mapper_params(info));
  if (!mapper) {
    return Error{ErrorCode::kInvalidArgument, mapper.error().message,
                 "/parameters/grid/resolution_m"};
  }
  return outline_of(*mapper);
}

Result<void> MapLibrary::remove(std::string_view name, const ExpectedRevision& expected) {
  return retrying([&] { return remove_once(name, expected); });
}

Result<void> MapLibrary::remove_once(std::string_view name, const ExpectedRevision& expected) {
  if (expected) {
    const auto found = find(name);
    if (!found) return found.error();
    if (auto checked = check_revision(found->revision, expected); !checked) return checked;
  }
  return stores_->with_maps([&](MapStore& maps) { return maps.remove(name, expected); });
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

Result<MapGrowthReport> MapLibrary::grow(std::string_view name, std::span<const PosedScan> scans,
                                         const ExpectedRevision& expected) {
  return retrying([&] { return grow_once(name, scans, expected); });
}

Result<MapGrowthReport> MapLibrary::grow(std::string_view name, std::span<const RobotScan> scans,
                                         const ExpectedRevision& expected) {
  return retrying([&] { return grow_once(name, scans, expected); });
}

template <typename Scan>
Result<MapGrowthReport> MapLibrary::grow_once(std::string_view name, std::span<const Scan> scans,
                                              const ExpectedRevision& expected) {
  constexpr bool kHavePoses = std::is_same_v<Scan, PosedScan>;
  auto found = find(name);
  if (!found) return found.error();
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The batch before this one may just have changed it.
  if (!found) return found.error();
  if (auto error = mixed(*found, kHavePoses)) return *error;
  if (auto rebuilt = rebuild(*growing, *found); !rebuilt) return rebuilt.error();

  const auto selected = fresh_scans(*stores_, found->id, scans);
  if (!selected) return selected.error();
  const std::vector<const Scan*>& fresh = *selected;
  MapGrowthReport report{.accepted = fresh.size(),
                         .duplicates = scans.size() - fresh.size(),
                         .key_frames = found->key_frame_count,
                         .features = found->feature_count,
                         .revision = found->revision};
  if (fresh.empty()) return report;
  if (const auto checked = check_revision(found->revision, expected); !checked)
    return checked.error();

  // From here on what is in memory is ahead of the store, until the store has the growth too.
  Mapper mapper = std::move(*growing->mapper);
  LidarOdometry odometry;
  if constexpr (!kHavePoses) {
    if (auto error = too_late(fresh, scans, mapper)) {
      growing->mapper = std::move(mapper);
      return *error;
    }
    odometry = continued(growing->odometry, mapper);
  }
  SeenArea seen = growing->seen;
  const MapperParams params = mapper_params(*found);
  growing->forget();
  std::vector<double> new_stamps;
  std::vector<PosedScan> new_key_frames;
  for (const Scan* scan : fresh) {
    new_stamps.push_back(scan->scan.stamp);
    PosedScan posed = posed_by(odometry, *scan);
    if (!mapper.is_key_frame(posed)) continue;
    if (auto error = mapper.reject(posed)) return at_scan(*error, scan - scans.data());
    mapper.add(posed);
    seen.add(posed, params);
    if (auto error = seen.reject(mapper.bounds(), params))
      return at_scan(*error, scan - scans.data());
    new_key_frames.push_back(std::move(posed));
  }
  const storage::MapGrowth growth{.stamps = new_stamps,
                                  .new_key_frames = new_key_frames,
                                  .outline = outline_of(mapper),
                                  .drifts = !kHavePoses};
  const auto grown = stores_->with_maps(
      [&](MapStore& maps) { return maps.grow(found->id, found->revision, growth, now_()); });
  if (!grown) return grown.error();
  growing->mapper = std::move(mapper);
  growing->seen = seen;
  if constexpr (!kHavePoses) growing->odometry = std::move(odometry);
  growing->revision = grown->revision;
  report.key_frames = grown->key_frame_count;
  report.features = grown->feature_count;
  report.revision = grown->revision;
  return report;
}

Result<MapInfo> MapLibrary::set_trajectory(std::string_view name,
                                           std::span<const api::StampedPose> poses,
                                           const ExpectedRevision& expected) {
  return retrying([&] { return set_trajectory_once(name, poses, expected); });
}

Result<MapInfo> MapLibrary::set_trajectory_once(std::string_view name,
                                                std::span<const api::StampedPose> poses,
                                                const ExpectedRevision& expected) {
  auto found = find(name);
  if (!found) return found.error();
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The change before this one may just have come.
  if (!found) return found.error();
  if (const auto checked = check_revision(found->revision, expected); !checked)
    return checked.error();
  if (found->has_floor_map) return no_key_frames();
  auto key_frames = stores_->with_maps([&](MapStore& maps) { return maps.key_frames(found->id); });
  if (!key_frames) return key_frames.error();
  const auto moved = poses_of(*key_frames, poses);
  if (!moved) return moved.error();
  const auto mapper = mapper_of(moved_to(*moved, std::move(*key_frames)), mapper_params(*found));
  if (!mapper) return Error{ErrorCode::kInvalidArgument, mapper.error().message, "/poses"};
  const MapperParams params = mapper_params(*found);
  if (const auto error = SeenArea(*mapper, params).reject(mapper->bounds(), params))
    return Error{error->code, error->message, "/poses"};
  return stores_->with_maps([&](MapStore& maps) {
    return maps.move_key_frames(found->id, found->revision, *moved, outline_of(*mapper), now_());
  });
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
  const auto outline = outline_of(*archive);
  if (!outline) return bad_archive(outline.error().message);
  return stores_->with_maps(
      [&](MapStore& maps) { return maps.restore(name, *archive, *outline, now_()); });
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
  if (auto map = cache_.find({info.id, info.revision})) return map;
  const auto growing = this->growing(info.id);
  const std::lock_guard lock(growing->mutex);
  const auto current = find(info.name);
  if (!current) return current.error();
  if (current->id != info.id) return another_map(info.name);
  const MapCache::Key key{current->id, current->revision};
  if (auto map = cache_.find(key)) return map;
  auto content = content_of(*growing, *current, progress);
  if (!content) return content.error();
  const auto map = std::make_shared<const LocalizationMap>(current->name, current->revision,
                                                           std::move(*content));
  cache_.keep(key, map);
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
  if (auto stored_too = store_sketch(info, sketch_of(content.features, content.grid)); !stored_too)
    return stored_too.error();
  return made;
}

Result<MapSketch> MapLibrary::make_sketch(const MapInfo& info) {
  const auto growing = this->growing(info.id);
  const std::lock_guard lock(growing->mutex);
  const auto current = find(info.name);
  if (!current) return current.error();
  if (current->id != info.id || current->revision != info.revision) return another_map(info.name);
  const auto content = content_of(*growing, *current, {});
  if (!content) return content.error();
  MapSketch sketch = sketch_of(content->features, content->grid);
  if (auto stored = store_sketch(*current, sketch); !stored) return stored.error();
  return sketch;
}

Result<void> MapLibrary::store_sketch(const MapInfo& info, const MapSketch& sketch) {
  return stores_->with_maps(
      [&](MapStore& maps) { return maps.store_sketch(info.id, info.revision, sketch); });
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
  if (!was_growing) growing.forget();  // Its keyframes are needed for growing only.
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
  growing.seen = SeenArea(*growing.mapper, mapper_params(info));
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
  for (auto last = growing_.end(); growing_.size() >= max_mappers_;) {
    if (last == growing_.begin()) break;
    --last;
    if (last->use_count() == 1) last = growing_.erase(last);
  }
  return growing_.emplace_front(std::make_shared<GrowingMap>(map_id));
}

}  // namespace cornerfix::server

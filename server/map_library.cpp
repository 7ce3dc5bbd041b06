#include "server/map_library.hpp"

#include <algorithm>
#include <optional>
#include <string>

#include <cornerfix/mapper.hpp>

#include "server/growing_map.hpp"
#include "server/map_outline.hpp"
#include "server/trajectory_poses.hpp"

namespace cornerfix::server {

using storage::MapInfo;
using storage::MapStore;

namespace {

bool is_scan_of(const LaserScan& scan, const api::Lidar& lidar) {
  return scan.angle_min == lidar.angle_min && scan.angle_increment == lidar.angle_increment &&
         scan.range_min == lidar.range_min && scan.range_max == lidar.range_max;
}

Error bad_archive(std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message), "/archive"};
}

/// As a share of the work.
constexpr double kRestoreStoringBegins = 0.5;

Error restore_given_up() {
  return {ErrorCode::kUnavailable, "the restoring of the archive was given up", ""};
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
Error too_large_now(const Error& error) { return {ErrorCode::kConflict, error.message, "map"}; }

Error another_map(const std::string& name) {
  return {ErrorCode::kNotFound, "the map " + name + " was changed or replaced", ""};
}

Error no_key_frames() {
  return {ErrorCode::kConflict,
          "the map was made from a floor map: it has no key frames that could move", "/map"};
}

}  // namespace

Result<MapContent> content_of(const Mapper& mapper, const MapperParams& params, bool drifts,
                              const MapLibrary::Progress& progress) {
  if (!drifts) return mapper.build();
  const auto optimized = optimize_trajectory(mapper.key_frames(), progress);
  if (!optimized) return optimized.error();
  const auto moved = mapper_of(moved_to(optimized->T_map_base_link, mapper.key_frames()), params);
  if (!moved) return too_large_now(moved.error());
  return moved->build();
}

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
                             const ExpectedMap& expected) {
  return retrying([&] { return put_once(name, request, expected); });
}

Result<bool> MapLibrary::put_once(std::string_view name, const api::PutMapRequest& request,
                                  const ExpectedMap& expected) {
  if (!request.parameters_json && !expected) return store_entry(name, request);
  auto found = find(name);
  if (!found && found.error().code != ErrorCode::kNotFound) return found.error();
  if (!found) {
    if (const auto checked = check_expected(MapInfo{}, expected); !checked) return checked.error();
    return store_entry(name, request, storage::MapRemake{});
  }
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The change before this one may just have come.
  if (!found) return found.error();
  if (const auto checked = check_expected(*found, expected); !checked) return checked.error();
  if (!request.parameters_json) {
    return store_entry(name, request,
                       storage::MapRemake{*expected, {found->feature_count, found->bounds}});
  }
  const auto merged = api::merged_parameters(found->parameters_json, *request.parameters_json);
  if (!merged) return merged.error();
  MapInfo remade = *found;
  remade.parameters_json = *merged;
  const auto outline = outline_with(remade);
  if (!outline) return outline.error();
  return store_entry(
      name, {request.description, request.lidar, *merged},
      storage::MapRemake{.known = expected.value_or(known(*found)), .outline = *outline});
}

Result<bool> MapLibrary::store_entry(std::string_view name, const api::PutMapRequest& request,
                                     const std::optional<storage::MapRemake>& remake) {
  std::optional<std::string> lidar_json;
  if (request.lidar) lidar_json = api::lidar_to_json(*request.lidar);
  return stores_->with_maps([&](MapStore& maps) {
    return maps.put(name, request.description, lidar_json, request.parameters_json, now_(), remake);
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

Result<void> MapLibrary::remove(std::string_view name, const ExpectedMap& expected) {
  return retrying([&] { return remove_once(name, expected); });
}

Result<void> MapLibrary::remove_once(std::string_view name, const ExpectedMap& expected) {
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

Result<MapInfo> MapLibrary::set_trajectory(std::string_view name,
                                           std::span<const api::StampedPose> poses,
                                           const ExpectedMap& expected) {
  return retrying([&] { return set_trajectory_once(name, poses, expected); });
}

Result<MapInfo> MapLibrary::set_trajectory_once(std::string_view name,
                                                std::span<const api::StampedPose> poses,
                                                const ExpectedMap& expected) {
  auto found = find(name);
  if (!found) return found.error();
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The change before this one may just have come.
  if (!found) return found.error();
  if (const auto checked = check_expected(*found, expected); !checked) return checked.error();
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

Result<MapInfo> MapLibrary::restore(std::string_view name, std::span<const std::uint8_t> bytes,
                                    const WorkProgress& progress) {
  if (progress && !progress("reading", 0.0)) return restore_given_up();
  const auto archive = storage::decode_archive(bytes);
  if (!archive) return at_part(archive.error());
  if (!api::is_put_map_request(archive->description, archive->lidar_json, archive->parameters_json))
    return bad_archive("its description, lidar or parameters are not as a server writes them");
  const auto outline = outline_of(*archive);
  if (!outline) return bad_archive(outline.error().message);
  if (progress && !progress("storing", kRestoreStoringBegins)) return restore_given_up();
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
  if (auto kept = store_content(info, *made); !kept) return kept.error();
  return made;
}

Result<void> MapLibrary::store_content(const MapInfo& info, const MapContent& content) {
  auto stored = stores_->with_maps(
      [&](MapStore& maps) { return maps.store_content(info.id, info.revision, content); });
  if (!stored) return stored;
  return store_sketch(info, sketch_of(content.features, content.grid));
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
  auto built = server::content_of(*growing.mapper, mapper_params(info), info.drifts, progress);
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

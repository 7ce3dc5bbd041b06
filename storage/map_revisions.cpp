#include "storage/map_revisions.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <utility>
#include <vector>

#include "storage/database.hpp"
#include "storage/map_source.hpp"
#include "storage/map_store.hpp"
#include "storage/map_tables.hpp"

namespace cornerfix::storage {
namespace {

constexpr std::array<std::string_view, 7> kOriginNames = {
    "", "settings", "scans", "trajectory", "occupancy_map", "archive", "roll_back"};

std::optional<std::chrono::sys_seconds> time_of(std::string_view text) {
  int year = 0;
  unsigned month = 0;
  unsigned day = 0;
  int hour = 0;
  int minute = 0;
  int second = 0;
  const int read = std::sscanf(std::string(text).c_str(), "%d-%u-%uT%d:%d:%dZ", &year, &month, &day,
                               &hour, &minute, &second);
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month),
                                         std::chrono::day(day)};
  if (read != 6 || !date.ok()) return std::nullopt;
  return std::chrono::sys_days(date) + std::chrono::hours(hour) + std::chrono::minutes(minute) +
         std::chrono::seconds(second);
}

bool has_content(const MapInfo& info) { return info.key_frame_count > 0 || info.has_floor_map; }

bool is_worth_keeping(const MapInfo& info, const RevisionChange& change) {
  if (!has_content(info)) return false;
  const bool is_within_run =
      change.origin == RevisionOrigin::kScans && info.revision_origin == RevisionOrigin::kScans &&
      seconds_between(info.revision_created, change.now).value_or(0) < kMappingPauseS;
  return !is_within_run;
}

MapRevision revision_of(const MapInfo& info) {
  return {.revision = info.revision,
          .digest = info.digest,
          .created = info.revision_created,
          .origin = info.revision_origin,
          .feature_count = info.feature_count};
}

std::string list_of(const std::vector<MapRevision>& revisions) {
  std::string text;
  for (const MapRevision& revision : revisions) {
    if (!text.empty()) text += ", ";
    text += std::to_string(revision.revision);
  }
  return text;
}

/// The present revision and those kept, newest first.
std::vector<MapRevision> all_revisions(MapTables& maps, const MapInfo& info) {
  std::vector<MapRevision> revisions = maps.kept_revisions(info.id);
  revisions.insert(revisions.begin(), revision_of(info));
  return revisions;
}

}  // namespace

std::string_view to_string(RevisionOrigin origin) {
  return kOriginNames[static_cast<std::size_t>(origin)];
}

RevisionOrigin revision_origin_from(std::string_view name) {
  const auto found = std::ranges::find(kOriginNames, name);
  if (found == kOriginNames.end()) return RevisionOrigin::kUnknown;
  return static_cast<RevisionOrigin>(found - kOriginNames.begin());
}

std::optional<std::int64_t> seconds_between(std::string_view begin, std::string_view end) {
  const auto first = time_of(begin);
  const auto last = time_of(end);
  if (!first || !last) return std::nullopt;
  return (*last - *first).count();
}

Result<void> keep_revision(MapTables& maps, const MapRow& map, const RevisionChange& change,
                           std::size_t limit) {
  if (!is_worth_keeping(map.info, change)) return {};
  if (limit > 0) {
    const auto archive = archive_of(maps, map);
    // What cannot be read cannot be kept, and must not hinder a change that mends the map.
    if (!archive && archive.error().code == ErrorCode::kCorruptData) return {};
    if (!archive) return archive.error();
    const auto bytes = encode_archive(*archive);
    if (!bytes) return bytes.error();
    if (bytes->size() > kMaxKeptArchiveBytes) return {};
    maps.insert_revision(map.info.id, revision_of(map.info), *bytes);
  }
  maps.remove_old_revisions(map.info.id, limit);
  return {};
}

Result<std::vector<MapRevision>> MapStore::revisions(std::string_view name) {
  return guarded([&]() -> Result<std::vector<MapRevision>> {
    const auto transaction = database_->begin(Access::kRead);
    MapTables& maps = database_->maps();
    const std::optional<MapRow> map = maps.find(name);
    if (!map) return unknown_map(name);
    return all_revisions(maps, map->info);
  });
}

Result<std::vector<std::uint8_t>> MapStore::revision_archive(std::string_view name,
                                                             std::uint64_t revision) {
  return guarded([&]() -> Result<std::vector<std::uint8_t>> {
    const auto transaction = database_->begin(Access::kRead);
    MapTables& maps = database_->maps();
    const std::optional<MapRow> map = maps.find(name);
    if (!map) return unknown_map(name);
    if (auto archive = maps.revision_archive(map->info.id, revision)) return std::move(*archive);
    return Error{ErrorCode::kNotFound,
                 "the map '" + std::string(name) + "' has no revision " + std::to_string(revision) +
                     "; it has " + list_of(all_revisions(maps, map->info)),
                 "revision"};
  });
}

Result<void> MapStore::insert_revision(std::int64_t map_id, const MapRevision& revision,
                                       std::span<const std::uint8_t> archive) {
  return guarded([&]() -> Result<void> {
    const auto transaction = database_->begin(Access::kWrite);
    database_->maps().insert_revision(map_id, revision, archive);
    transaction->commit();
    return {};
  });
}

Result<MapInfo> MapStore::roll_back(std::int64_t map_id, std::uint64_t expected_revision,
                                    const MapArchive& archive, const MapOutline& outline,
                                    std::string_view now) {
  return guarded([&]() -> Result<MapInfo> {
    const auto transaction = database_->begin(Access::kWrite);
    MapTables& maps = database_->maps();
    Result<MapRow> map = find_at_revision(maps, map_id, expected_revision);
    if (!map) return map.error();
    const RevisionChange change{RevisionOrigin::kRollBack, now};
    if (const auto kept = keep_revision(maps, *map, change, kept_revisions_); !kept)
      return kept.error();
    maps.remove_source(map_id);
    insert_source(maps, *map, archive);
    MapInfo& info = map->info;
    info.lidar_json = archive.lidar_json;
    info.parameters_json = archive.parameters_json;
    set_outline(info, outline);
    info.updated = now;
    seal_revision(*map, change);
    maps.update(*map);
    transaction->commit();
    return std::move(info);
  });
}

}  // namespace cornerfix::storage

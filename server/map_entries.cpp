#include "server/map_entries.hpp"

#include <fmt/format.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "api/revision_codec.hpp"
#include "server/growing_map.hpp"

namespace cornerfix::server {

api::MapEntry entry_of(const storage::MapInfo& info) {
  return {.name = info.name,
          .description = info.description,
          .revision = info.revision,
          .digest = info.digest,
          .has_floor_map = info.has_floor_map,
          .key_frames = info.key_frame_count,
          .features = info.feature_count,
          .bounds = info.bounds,
          .created = info.created,
          .updated = info.updated,
          .lidar = api::lidar_from_json(info.lidar_json),
          .parameters = mapper_params(info)};
}

api::Json revisions_of(std::string_view map, const std::vector<storage::MapRevision>& revisions) {
  std::vector<api::RevisionEntry> entries;
  entries.reserve(revisions.size());
  for (const storage::MapRevision& revision : revisions) {
    entries.push_back({.revision = revision.revision,
                       .digest = revision.digest,
                       .created = revision.created,
                       .origin = storage::to_string(revision.origin),
                       .features = revision.feature_count,
                       .archive_bytes = revision.archive_bytes,
                       .is_current = entries.empty()});
  }
  return api::render_revisions(map, entries);
}

api::FloorMapResult entry_of(const FloorMapReport& report) {
  return {.revision = report.info.revision,
          .digest = report.info.digest,
          .features = report.info.feature_count,
          .warnings = report.warnings};
}

api::MapBatchResult entry_of(const MapGrowthReport& report) {
  return {.accepted = report.accepted,
          .duplicates = report.duplicates,
          .key_frames = report.key_frames,
          .features = report.features,
          .revision = report.revision};
}

std::string map_entity_tag(std::uint64_t revision, std::string_view digest,
                           std::string_view description) {
  return fmt::format("\"{}-{}-{:x}\"", revision, digest,
                     std::hash<std::string_view>{}(description));
}

Error map_without_grid() {
  return {ErrorCode::kNotFound,
          "The map has no grid yet: it has neither key frames nor a floor map.", "map"};
}

}  // namespace cornerfix::server

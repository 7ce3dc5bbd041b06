// The present and the kept former revisions of a map.
#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/growing_map.hpp"
#include "server/map_library.hpp"
#include "server/map_outline.hpp"

namespace cornerfix::server {

using storage::MapInfo;
using storage::MapRevision;
using storage::MapStore;

Result<std::vector<MapRevision>> MapLibrary::revisions(std::string_view name) {
  return stores_->with_maps([&](MapStore& maps) { return maps.revisions(name); });
}

Result<MapVersion> MapLibrary::version(std::string_view name, std::uint64_t revision) {
  const auto info = find(name);
  if (!info) return info.error();
  if (info->revision == revision) return MapVersion{.digest = info->digest, .is_current = true};
  const auto kept = revisions(name);
  if (!kept) return kept.error();
  const auto found = std::ranges::find(*kept, revision, &MapRevision::revision);
  return MapVersion{.digest = found == kept->end() ? std::string() : found->digest};
}

Result<std::vector<std::uint8_t>> MapLibrary::archive(std::string_view name,
                                                      std::uint64_t revision) {
  const auto info = find(name);
  if (!info) return info.error();
  if (info->revision == revision) return archive(name);
  return stores_->with_maps([&](MapStore& maps) { return maps.revision_archive(name, revision); });
}

Result<MapInfo> MapLibrary::roll_back(std::string_view name, std::uint64_t revision,
                                      const ExpectedMap& expected) {
  return retrying([&] { return roll_back_once(name, revision, expected); });
}

Result<MapInfo> MapLibrary::roll_back_once(std::string_view name, std::uint64_t revision,
                                           const ExpectedMap& expected) {
  auto found = find(name);
  if (!found) return found.error();
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The change before this one may just have come.
  if (!found || found->revision == revision) return found;
  if (const auto checked = check_expected(*found, expected); !checked) return checked.error();
  const auto bytes =
      stores_->with_maps([&](MapStore& maps) { return maps.revision_archive(name, revision); });
  if (!bytes) return bytes.error();
  const auto archive = storage::decode_archive(*bytes);
  if (!archive) return Error{ErrorCode::kCorruptData, archive.error().message, ""};
  const auto outline = outline_of(*archive);
  if (!outline) return Error{ErrorCode::kConflict, outline.error().message, "map"};
  return stores_->with_maps([&](MapStore& maps) {
    return maps.roll_back(found->id, found->revision, *archive, *outline, now_());
  });
}

}  // namespace cornerfix::server

#include "server/start_region_check.hpp"

#include <algorithm>
#include <cstdio>

namespace cornerfix::server {
namespace {

using storage::MapInfo;

bool may_be_in(const StartRegion& region, const MapInfo& map) {
  if (!map.bounds) return true;
  const Point2 nearest = region.center.cwiseMax(map.bounds->min).cwiseMin(map.bounds->max);
  return (region.center - nearest).norm() <= region.radius_m;
}

Error outside(const StartRegion& region, const std::optional<MapInfo>& only) {
  char text[200];
  std::snprintf(text, sizeof text, "x %.6g, y %.6g with radius_m %.6g lies outside ",
                region.center.x(), region.center.y(), region.radius_m);
  std::string message = text;
  if (!only) return {ErrorCode::kInvalidArgument, message + "all maps of the session", "/near"};
  const Bounds& bounds = *only->bounds;
  std::snprintf(text, sizeof text, ", expected x from %.6g to %.6g and y from %.6g to %.6g",
                bounds.min.x(), bounds.max.x(), bounds.min.y(), bounds.max.y());
  return {ErrorCode::kInvalidArgument, message + "the map " + only->name + text, "/near"};
}

Result<void> check_within(const StartRegion& region, const std::vector<MapInfo>& maps) {
  if (maps.empty()) return {};
  const bool is_within =
      std::ranges::any_of(maps, [&](const MapInfo& map) { return may_be_in(region, map); });
  if (is_within) return {};
  return outside(region, maps.size() == 1 ? std::optional(maps.front()) : std::nullopt);
}

Result<void> check_within_every_map(MapLibrary& library, const StartRegion& region) {
  constexpr std::size_t kPage = 100;
  std::string after;
  Result<void> checked;
  while (true) {
    const auto page = library.list(after, kPage);
    if (!page) return page.error();
    if (page->empty()) return checked;
    checked = check_within(region, *page);
    if (checked) return checked;
    if (page->size() < kPage) return after.empty() ? checked : outside(region, std::nullopt);
    after = page->back().name;
  }
}

}  // namespace

Result<void> check_start_region(MapLibrary& library, const std::optional<StartRegion>& region,
                                const std::vector<std::string>& searched) {
  if (!region) return {};
  if (region->map.empty() && searched.empty()) return check_within_every_map(library, *region);
  const bool is_searched =
      searched.empty() || std::ranges::find(searched, region->map) != searched.end();
  if (!region->map.empty() && !is_searched) {
    return Error{ErrorCode::kInvalidArgument, "must be one of the session's maps", "/near/map"};
  }
  std::vector<MapInfo> maps;
  for (const std::string& name :
       region->map.empty() ? searched : std::vector<std::string>{region->map}) {
    auto info = library.find(name);
    if (!info && info.error().code == ErrorCode::kNotFound && !searched.empty()) continue;
    if (!info) return info.error();
    maps.push_back(std::move(*info));
  }
  return check_within(*region, maps);
}

}  // namespace cornerfix::server

#include "core/src/search/map_selection.hpp"

#include <algorithm>
#include <utility>

#include "core/src/search/global_search.hpp"

namespace cornerfix {
namespace {

constexpr double kSelectionMargin = 0.2;    // below the best map [nat per hit]
constexpr std::size_t kMostRanked = 32;     // maps that are loaded by rank
constexpr std::size_t kMostUnranked = 128;  // maps that are all loaded where corners are few,
constexpr double kDistanceBeforeAll = 3.0;  // after this distance [m]
constexpr std::size_t kProposedByFewCorners = 4;

/// Loads a map unless the selection holds it. Returns whether it is there.
bool add(MapSelection& selection, MapSource& source, MapKey key, std::size_t most) {
  if (std::ranges::find(selection.keys, key) != selection.keys.end()) return true;
  if (selection.keys.size() >= most) return false;
  std::size_t held_bytes = 0;
  for (const LocalizationMapPtr& held : selection.maps) held_bytes += held->bytes();
  LocalizationMapPtr map = source.load(key, held_bytes);
  if (!map) return false;
  selection.keys.push_back(key);
  selection.maps.push_back(std::move(map));
  return true;
}

void add_ranked(MapSelection& selection, MapSource& source, const View& view) {
  const std::vector<RankedMap> ranked = source.rank({view.corners, view.evidence.ends});
  if (ranked.empty()) return;
  const double least = ranked.front().mean_weight - kSelectionMargin;
  for (const RankedMap& one : ranked) {
    if (one.mean_weight < least) break;
    if (!add(selection, source, one.key, kMostRanked)) ++selection.unsearched;
  }
}

void add_without_ranking(MapSelection& selection, MapSource& source, const View& view,
                         bool may_load_all) {
  if (may_load_all) {
    for (const MapKey key : source.keys()) std::ignore = add(selection, source, key, kMostUnranked);
  } else if (source.size() <= kMostUnranked) {  // Among more, any four would show nothing.
    std::vector<RankedMap> ranked = source.rank({view.corners, view.evidence.ends});
    if (ranked.size() > kProposedByFewCorners) ranked.resize(kProposedByFewCorners);
    for (const RankedMap& one : ranked) std::ignore = add(selection, source, one.key, kMostRanked);
  }
  selection.unsearched = source.size() - std::min(source.size(), selection.keys.size());
}

}  // namespace

bool is_chosen_by_corners(MapSource& source, const std::optional<StartRegion>& region) {
  if (!region) return source.size() > kFewMaps;
  return region->map.empty() && source.size() > kMostUnranked;
}

MapSelection select_maps(MapSource& source, const View& view, SelectionRequest request) {
  MapSelection selection = std::move(request.kept);
  selection.unsearched = 0;
  selection.is_ranked = false;
  const std::optional<StartRegion>& region = request.region;
  if (region && !region->map.empty()) {
    const auto key = source.find(region->map);
    if (key && !add(selection, source, *key, kMostRanked)) ++selection.unsearched;
  } else if (is_chosen_by_corners(source, region) && view.corners.size() >= kEnoughCorners) {
    selection.is_ranked = true;
    add_ranked(selection, source, view);
  } else {
    const bool is_time =
        region || source.size() <= kFewMaps || request.distance_m >= kDistanceBeforeAll;
    add_without_ranking(selection, source, view, is_time && source.size() <= kMostUnranked);
  }
  return selection;
}

}  // namespace cornerfix

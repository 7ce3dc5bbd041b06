// In which maps a session's robot is looked for.
#include <algorithm>
#include <iterator>
#include <utility>

#include "server/localization_service.hpp"
#include "server/session_maps.hpp"

namespace cornerfix::server {

using storage::MapInfo;

namespace {

constexpr std::size_t kMapsAPage = 1000;

}  // namespace

Result<void> LocalizationService::use_current_maps(LiveSession& session) {
  const bool holds_what_it_needs =
      session.is_ranked || session.holds_all_maps == (session.confirmed_map == 0);
  if (session.localizer && session.maps_epoch == session.epoch && holds_what_it_needs) return {};
  const auto is_ranked = is_in_ranked_maps(session);
  if (!is_ranked) return is_ranked.error();
  if (*is_ranked) return use_ranked_maps(session);
  auto infos = maps_of(session);
  if (!infos) return infos.error();
  // A map that is gone, or empty now, leaves the robot lost: it needs all others.
  const auto tracked = std::ranges::find(*infos, session.confirmed_map, &MapInfo::id);
  if (tracked == infos->end() || !tracked->bounds) session.confirmed_map = 0;
  auto maps = session.confirmed_map != 0
                  ? load_one(*maps_, *infos, session.confirmed_map, session.free_area_m2)
                  : load_all(*maps_, *infos, settings_.max_searched_map_bytes,
                             !session.record.maps.empty());
  if (!maps) return maps.error();
  session.use_maps(std::move(*maps), settings_.clock_ms);
  session.maps_epoch = session.epoch;
  table_.forget_least_used(settings_.max_session_bytes);
  return {};
}

Result<bool> LocalizationService::is_in_ranked_maps(const LiveSession& session) {
  if (!ranking_ || !session.record.maps.empty()) return false;
  if (auto fresh = ranking_->refresh(); !fresh) return fresh.error();
  return ranking_->size() > settings_.max_maps_without_ranking;
}

Result<void> LocalizationService::use_ranked_maps(LiveSession& session) {
  const std::uint64_t version = ranking_->version();
  const bool is_same = session.localizer && session.is_ranked && session.ranking_version == version;
  if (!is_same) {
    std::optional<std::vector<LocalizationMapPtr>> revisions;
    if (session.localizer && session.is_ranked) {
      auto current = current_revisions(session);
      if (!current) return current.error();
      revisions = std::move(*current);
    }
    if (revisions) {
      if (*revisions != session.localizer->maps())
        session.localizer->replace_maps(std::move(*revisions));
    } else {
      // Kept until the localizer has it. A map that is gone leaves the robot lost.
      const auto tracked = load_ranked(session.tracked_map());
      if (!tracked && tracked.error().code != ErrorCode::kNotFound) return tracked.error();
      session.use_source(ranked_maps_, settings_.clock_ms);
      table_.forget_least_used(settings_.max_session_bytes);
    }
  }
  session.ranking_version = version;
  session.maps_epoch = session.epoch;
  return {};
}

Result<std::optional<std::vector<LocalizationMapPtr>>> LocalizationService::current_revisions(
    const LiveSession& session) {
  std::vector<LocalizationMapPtr> maps = session.localizer->maps();
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const MapKey key = session.localizer->map_keys()[i];
    const auto entry = ranking_->entry(key);
    if (!entry) return std::optional<std::vector<LocalizationMapPtr>>();
    if (entry->revision == maps[i]->revision()) continue;
    auto newer = load_ranked(key);
    if (!newer && newer.error().code == ErrorCode::kNotFound)
      return std::optional<std::vector<LocalizationMapPtr>>();
    if (!newer) return newer.error();
    maps[i] = std::move(*newer);
  }
  return std::optional(std::move(maps));
}

Result<LocalizationMapPtr> LocalizationService::load_ranked(MapKey key) {
  const auto entry = ranking_->entry(key);
  if (!entry) return Error{ErrorCode::kNotFound, "there is no map " + std::to_string(key), ""};
  return maps_->load(MapRanking::info_of(key, *entry));
}

Result<std::vector<MapInfo>> LocalizationService::maps_of(LiveSession& session) {
  if (session.record.maps.empty()) return every_map();
  std::vector<MapInfo> infos;
  for (const std::string& name : session.record.maps) {
    auto info = maps_->find(name);
    if (!info && info.error().code != ErrorCode::kNotFound) return info.error();
    // A new map of an old name is another map.
    if (!info || session.ids_by_name.try_emplace(name, info->id).first->second != info->id) {
      return Error{ErrorCode::kConflict, "the session's map " + name + " was deleted", ""};
    }
    infos.push_back(std::move(*info));
  }
  return infos;
}

Result<std::vector<MapInfo>> LocalizationService::every_map() {
  std::vector<MapInfo> infos;
  for (;;) {
    auto page = maps_->list(infos.empty() ? "" : infos.back().name, kMapsAPage);
    if (!page) return page.error();
    std::ranges::move(*page, std::back_inserter(infos));
    if (page->size() < kMapsAPage) break;
  }
  // A new map comes last, so the others keep their places.
  std::ranges::sort(infos, {}, &MapInfo::id);
  return infos;
}

}  // namespace cornerfix::server

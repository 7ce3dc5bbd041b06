#include "server/live_session.hpp"

#include <algorithm>
#include <utility>

namespace cornerfix::server {

using storage::SessionRecord;

namespace {

/// Of a session with its localizer, as measured: its submap, and while it searches, what it has
/// looked at (docs/reliability.md, section 5).
constexpr std::size_t kTrackingBytes = 600'000;
constexpr std::size_t kSearchingBytes = 3'000'000;

/// The newest scan of the local map, as it lies from the last pose: what can be shown of a session
/// that was read from the store.
std::optional<RobotScan> newest_scan(const LocalizerState& state) {
  if (state.submap.empty()) return std::nullopt;
  const SubmapScan& newest = *state.submap.back();
  const Pose2 T_base_link_then = inverse(state.T_submap_base_link) * newest.T_submap_base_link;
  return RobotScan{.scan = newest.scan,
                   .T_base_link_laser = T_base_link_then * newest.T_base_link_laser,
                   .T_odom_base_link = std::nullopt};
}

}  // namespace

SessionView LiveSession::view() const {
  return {.id = record.id,
          .robot = record.robot,
          .created = record.created,
          .last_seen = record.last_used,
          .maps = record.maps,
          .lidars = lidars,
          .params = params,
          .region = localizer ? localizer->region() : stored_state.region,
          .expected_sequence = record.expected_sequence,
          .status = status,
          .last_answer = is_answered ? record.last_answer : std::string(),
          .last_scan = last_scan,
          .feature_points = feature_points};
}

std::optional<double> LiveSession::last_stamp() const {
  return localizer ? localizer->last_stamp() : stored_state.last_stamp;
}

LocalizerState LiveSession::state() const {
  if (!localizer) return stored_state;
  LocalizerState state = localizer->state();
  if (state.tracked_map >= 0) {
    const auto at = static_cast<std::size_t>(state.tracked_map);
    state.tracked_map = static_cast<int>(held_map_ids()[at]);
  }
  return state;
}

storage::SessionChange LiveSession::change(const LocalizerState& state) const {
  return {record.id,
          {.previous_sequence = stored_sequence,
           .expected_sequence = record.expected_sequence,
           .last_answer = record.last_answer,
           .state = &state,
           .now = record.last_used,
           .last_batch = record.last_batch,
           .previous_scans = stored_scans}};
}

void LiveSession::note_stored(const LocalizerState& state) {
  stored_sequence = record.expected_sequence;
  stored_scans = state.scans;
  unstored_since.reset();
}

void LiveSession::discard() {
  is_current = false;
  is_whole = false;
  unstored_since.reset();
}

bool LiveSession::is_same_as(const SessionRecord& stored) const {
  // Every batch raises the one number and a reset zeroes the other: both the same, nobody was here.
  return is_current && localizer && stored.expected_sequence == record.expected_sequence &&
         stored.state.scans == localizer->state().scans &&
         stored.state.region == localizer->region();
}

void LiveSession::load(SessionRecord stored, api::Lidars its_lidars) {
  lidars = std::move(its_lidars);
  params = api::params_from_json(stored.options_json);
  stored_state = std::exchange(stored.state, {});
  record = std::move(stored);
  for (std::size_t i = 0; i < record.maps.size(); ++i) {
    const std::int64_t map_id = record.map_ids[i];
    if (map_id > 0) ids_by_name.try_emplace(record.maps[i], map_id);
  }
  status = stored_state.status;
  note_confirmed(stored_state);
  drop_localizer();
  is_answered = stored_state.scans > 0;
  last_scan = newest_scan(stored_state);
  feature_points.clear();
  note_stored(stored_state);
  is_current = true;
  is_whole = true;
}

void LiveSession::reset(LocalizerState forgotten, const std::string& now) {
  if (localizer) localizer->reset(forgotten.region);
  stored_state = std::move(forgotten);
  confirmed_map = 0;
  search_begin.reset();
  status = Status::kCollecting;
  is_answered = false;
  last_scan.reset();
  feature_points.clear();
  record.last_used = now;
  note_stored(stored_state);
  is_current = true;
  is_whole = true;
}

void LiveSession::note_confirmed(const Answer& answer) {
  confirmed_map = 0;
  if (!answer.pose || !answer.pose->confirmed) return;
  const auto found = std::ranges::find(localizer->maps(), answer.pose->map);
  confirmed_map = held_map_ids()[static_cast<std::size_t>(found - localizer->maps().begin())];
}

void LiveSession::note_confirmed(const LocalizerState& state) {
  const bool is_confirmed = state.status == Status::kLocalized && state.confirmed;
  confirmed_map = is_confirmed && state.tracked_map > 0 ? state.tracked_map : 0;
}

void LiveSession::use_maps(SessionMaps loaded, const Localizer::Clock& clock) {
  std::vector<LocalizationMapPtr> maps = std::move(loaded.maps);
  std::vector<std::int64_t> ids = std::move(loaded.ids);
  holds_all_maps = loaded.holds_all;
  free_area_m2 = loaded.free_area_m2;
  if (localizer && !is_ranked && ids == map_ids) {
    if (maps != localizer->maps()) localizer->replace_maps(std::move(maps));
    return;
  }
  LocalizerState state = take_state();
  find_tracked(state, ids);
  localizer.emplace(std::move(maps), params, clock);
  is_ranked = false;
  localizer->restore(std::move(state));
  map_ids = std::move(ids);
  count_bytes();
}

void LiveSession::use_source(std::shared_ptr<MapSource> source, const Localizer::Clock& clock) {
  LocalizerState state = take_state();
  std::vector<MapKey> held;
  if (state.tracked_map > 0) held.push_back(state.tracked_map);
  localizer.emplace(std::move(source), held, params, clock);
  is_ranked = true;
  find_tracked(state, localizer->map_keys());
  localizer->restore(std::move(state));
  map_ids.clear();
  count_bytes();
}

std::int64_t LiveSession::tracked_map() const {
  return localizer ? state().tracked_map : stored_state.tracked_map;
}

LocalizerState LiveSession::take_state() {
  return localizer ? state() : std::exchange(stored_state, {});
}

void LiveSession::find_tracked(LocalizerState& state, const std::vector<std::int64_t>& ids) {
  if (state.tracked_map >= 0) {
    const auto found = std::ranges::find(ids, std::int64_t{state.tracked_map});
    const bool is_there = found != ids.end();
    state.tracked_map = is_there ? static_cast<int>(found - ids.begin()) : -1;
    if (!is_there) {
      confirmed_map = 0;
      state.region.reset();
      if (state.status == Status::kLocalized) state.status = Status::kLost;
    }
  }
  status = state.status;
}

void LiveSession::release_localizer() {
  drop_localizer();
  is_current = false;
}

void LiveSession::drop_localizer() {
  localizer.reset();
  is_ranked = false;
  map_ids.clear();
  count_bytes();
}

void LiveSession::count_bytes() {
  const std::size_t live = status == Status::kLocalized ? kTrackingBytes : kSearchingBytes;
  const std::size_t now = localizer ? live : 0;
  live_bytes_ += now - bytes;  // Wraps around where it shrinks.
  bytes = now;
}

}  // namespace cornerfix::server

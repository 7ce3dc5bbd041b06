#include "server/localization_service.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/batch_digest.hpp"
#include "server/random_id.hpp"
#include "server/session_maps.hpp"
#include "server/start_region_check.hpp"

namespace cornerfix::server {

using storage::MapInfo;
using storage::MapStore;
using storage::SessionRecord;
using storage::SessionStore;

namespace {

constexpr int kMaxAttempts = 3;

/// Id of the newest session of a robot, if that is another one than `id`; else empty.
Result<std::string> superseding(SessionStore& sessions, const std::string& robot,
                                const std::string& id) {
  auto newest = sessions.newest(robot);
  if (newest && *newest == id) newest->clear();
  return newest;
}

std::vector<Result<void>> write_changes(StoreAccess& stores,
                                        std::span<const storage::SessionChange> changes) {
  auto written =
      stores.with_sessions([&](SessionStore& sessions) -> Result<std::vector<Result<void>>> {
        return sessions.update(changes);
      });
  if (written) return std::move(*written);
  std::vector<Result<void>> failed(changes.size(), Result<void>(written.error()));
  return failed;
}

Error no_such_session(const std::string& id) {
  return {ErrorCode::kNotFound, "there is no session " + id, ""};
}

}  // namespace

/// A session held for this thread alone.
class LocalizationService::LockedSession {
 public:
  explicit LockedSession(std::shared_ptr<LiveSession> session)
      : session_(std::move(session)), lock_(session_->mutex) {}
  LiveSession& operator*() const { return *session_; }
  LiveSession* operator->() const { return session_.get(); }

 private:
  std::shared_ptr<LiveSession> session_;
  std::unique_lock<std::mutex> lock_;
};

LocalizationService::LocalizationService(std::shared_ptr<StoreAccess> stores,
                                         std::shared_ptr<MapLibrary> maps,
                                         LocalizationServiceSettings settings,
                                         std::shared_ptr<MapRanking> ranking)
    : stores_(std::move(stores)),
      maps_(std::move(maps)),
      ranking_(std::move(ranking)),
      settings_(std::move(settings)),
      group_commit_([this](std::span<const storage::SessionChange> changes) {
        return write_changes(*stores_, changes);
      }) {
  if (ranking_) {
    ranked_maps_ =
        std::make_shared<RankedMapSource>(ranking_, maps_, settings_.max_searched_map_bytes);
  }
  if (settings_.checkpoint_interval.count() > 0)
    checkpoints_ = std::make_unique<Checkpoints>(stores_, settings_.checkpoint_interval);
}

LocalizationService::~LocalizationService() = default;

Result<std::optional<SessionView>> LocalizationService::create(
    const api::CreateSessionRequest& request) {
  std::vector<std::int64_t> map_ids;
  for (const std::string& map : request.maps) {
    const auto info = maps_->find(map);
    if (!info) return info.error();
    map_ids.push_back(info->id);
  }
  if (auto good = check_start_region(*maps_, request.region, request.maps); !good)
    return good.error();
  LocalizerState state;
  state.region = request.region;
  const std::string now = settings_.now();
  const SessionRecord record{.id = random_id(),
                             .robot = request.robot,
                             .created = now,
                             .maps = request.maps,
                             .lidar_json = api::lidars_to_json(request.lidars),
                             .options_json = request.options_json,
                             .expected_sequence = 0,
                             .last_answer = {},
                             .state = std::move(state),
                             .map_ids = std::move(map_ids),
                             .last_used = now};
  bool has_room = false;
  const auto inserted = stores_->with_sessions([&](SessionStore& sessions) -> Result<void> {
    const auto count = sessions.count(request.robot);
    if (!count) return count.error();
    const auto all = sessions.count_all();
    if (!all) return all.error();
    has_room = *count < settings_.max_sessions_per_robot && *all < settings_.max_sessions;
    if (!has_room) return {};
    return sessions.insert(record);
  });
  if (!inserted) return inserted.error();
  if (!has_room) return std::optional<SessionView>();
  auto view = find(record.id);
  if (!view) return view.error();
  return std::optional(std::move(*view));
}

Result<SessionView> LocalizationService::find(const std::string& id) {
  const auto session = lock(id);
  if (!session) return session.error();
  return view_of(**session);
}

Result<SessionView> LocalizationService::view_of(const LiveSession& session) {
  SessionView view = session.view();
  view.is_stale = is_stale(view.last_seen);
  auto newer = stores_->with_sessions(
      [&](SessionStore& sessions) { return superseding(sessions, view.robot, view.id); });
  if (!newer) return newer.error();
  view.superseded_by = std::move(*newer);
  return view;
}

bool LocalizationService::is_stale(const std::string& last_seen) const {
  return settings_.stale_before && last_seen < settings_.stale_before();
}

Result<void> LocalizationService::visit(const std::string& id,
                                        const std::function<void(const SessionView&)>& look) {
  const auto session = lock(id);
  if (!session) return session.error();
  look((*session)->view());
  return {};
}

Result<SessionList> LocalizationService::list(const SessionListRequest& request) {
  std::vector<std::string> superseded_by;
  auto records =
      stores_->with_session_list([&](SessionStore& sessions) -> Result<std::vector<SessionRecord>> {
        auto found = sessions.list(
            {.robot = request.robot, .after = request.after, .limit = request.limit + 1});
        if (!found) return found;
        for (const SessionRecord& record : *found) {
          auto newer = superseding(sessions, record.robot, record.id);
          if (!newer) return newer.error();
          superseded_by.push_back(std::move(*newer));
        }
        return found;
      });
  if (!records) return records.error();
  SessionList list;
  if (records->size() > request.limit) {
    records->pop_back();
    list.next = records->back().number;
  }
  for (std::size_t i = 0; i < records->size(); ++i) {
    SessionRecord& record = (*records)[i];
    const bool is_answered = record.state.scans > 0;
    list.sessions.push_back(
        {.id = std::move(record.id),
         .robot = std::move(record.robot),
         .created = std::move(record.created),
         .last_seen = record.last_used,
         .is_stale = is_stale(record.last_used),
         .superseded_by = std::move(superseded_by[i]),
         .maps = std::move(record.maps),
         .lidars = api::lidars_from_json(record.lidar_json).value_or(api::Lidars()),
         .params = api::params_from_json(record.options_json),
         .region = std::move(record.state.region),
         .expected_sequence = record.expected_sequence,
         .status = record.state.status,
         .last_answer = is_answered ? std::move(record.last_answer) : "",
         .is_damaged = record.is_damaged});
  }
  return list;
}

Result<void> LocalizationService::remove(const std::string& id) {
  table_.forget(id);
  return stores_->with_sessions([&](SessionStore& sessions) { return sessions.remove(id); });
}

Result<SessionView> LocalizationService::reset(const std::string& id,
                                               const std::optional<StartRegion>& region) {
  for (int attempt = 1;; ++attempt) {
    const auto locked = lock(id);
    if (!locked) return locked.error();
    LiveSession& session = **locked;
    if (auto good = check_start_region(*maps_, region, session.record.maps); !good)
      return good.error();
    session.is_current = false;  // Until the store has it too.
    LocalizerState forgotten;
    forgotten.region = region;
    const std::string now = settings_.now();
    storage::SessionChange change = session.change(forgotten);
    change.update.now = now;
    const auto saved = group_commit_.store(change);
    if (!saved && saved.error().code == ErrorCode::kConflict && attempt < kMaxAttempts) continue;
    if (!saved) return saved.error();
    session.reset(std::move(forgotten), now);
    return view_of(session);
  }
}

/// What is asked for never changes, so that a session in memory need not be compared with the
/// store.
Result<SessionHead> LocalizationService::head(const std::string& id) {
  if (auto known = table_.find(id)) {
    const LockedSession session(std::move(known));
    if (session->is_current) return SessionHead{session->record.robot, session->lidars};
  }
  const auto session = lock(id);
  if (!session) return session.error();
  return SessionHead{(*session)->record.robot, (*session)->lidars};
}

Result<std::string> LocalizationService::robot_of(const std::string& id) {
  return stores_->with_sessions([&](SessionStore& sessions) { return sessions.robot_of(id); });
}

Result<std::deque<api::PastAnswer>> LocalizationService::history(const std::string& id) {
  const auto session = lock(id);
  if (!session) return session.error();
  return (*session)->history.answers();
}

Result<BatchOutcome> LocalizationService::post_scans(const std::string& id,
                                                     const api::SessionScansRequest& request) {
  for (int attempt = 1;; ++attempt) {
    const auto locked = lock(id);
    if (!locked) return locked.error();
    LiveSession& session = **locked;
    const std::uint64_t expected = session.record.expected_sequence;
    if (request.sequence == expected) {
      auto outcome = take_batch(session, request);
      const bool overtaken = !outcome && outcome.error().code == ErrorCode::kConflict &&
                             !session.is_current && attempt < kMaxAttempts;
      if (overtaken) continue;  // Another process took the batch: answer as the store says.
      return outcome;
    }
    if (expected > 0 && request.sequence == expected - 1) {
      const std::uint64_t known = session.record.last_batch;
      if (known != 0 && known != digest_of(request.scans)) {
        return BatchOutcome{.expected_sequence = expected,
                            .is_another_batch = true,
                            .last_stamp = session.last_stamp()};
      }
      return BatchOutcome{.answer = session.record.last_answer};
    }
    return BatchOutcome{.expected_sequence = expected, .last_stamp = session.last_stamp()};
  }
}

Result<BatchOutcome> LocalizationService::take_batch(LiveSession& session,
                                                     const api::SessionScansRequest& request) {
  if (checkpoints_ && checkpoints_->is_overdue(session)) {
    if (auto stored = store(session); !stored) return stored.error();
  }
  if (auto ready = use_current_maps(session); !ready) return ready.error();
  const auto last_stamp = session.localizer->last_stamp();
  if (auto error = check_stamp(request.scans.front(), last_stamp, session.lidars)) return *error;

  session.is_current = false;  // Until the batch is saved.
  session.is_whole = false;
  std::optional<double> search_begin = session.search_begin;
  const auto prepare = [&](const Answer& answer) -> Result<void> {
    session.note_confirmed(answer);
    const bool is_ready = session.is_ranked || session.holds_all_maps || session.confirmed_map != 0;
    return is_ready ? Result<void>() : use_current_maps(session);
  };
  const auto processed =
      process_batch(*session.localizer, session.status, request.scans, search_begin, prepare);
  if (!processed) return processed.error();
  const ProcessedBatch& batch = *processed;
  session.note_confirmed(batch.answer);
  const RobotScan& last = request.scans.back();
  const std::string answer = settings_.render({.session = session.record.id,
                                               .sequence = request.sequence,
                                               .stamp = last.scan.stamp,
                                               .answer = batch.answer});
  session.record.expected_sequence = request.sequence + 1;
  session.record.last_batch = digest_of(request.scans);
  session.record.last_answer = answer;
  session.record.last_used = settings_.now();
  if (auto saved = save(session); !saved) return saved.error();
  session.history.add(batch.answer, request.sequence, session.record.last_used);
  session.status = batch.answer.status;
  session.is_searching = batch.answer.reason == Reason::kSearching;
  session.count_bytes();
  session.search_begin = search_begin;
  session.is_answered = true;
  session.last_scan = last;
  session.feature_points = session.localizer->local_features_base_link();
  if (settings_.recorded_answers > 0)
    session.history.record({answer, last, session.feature_points}, settings_.recorded_answers);
  session.is_current = true;
  session.is_whole = true;
  // Sessions hold the maps that they need, also until their next batch.
  table_.release_localizers([this] { return maps_->make_room(); });
  if (settings_.on_batch) {
    settings_.on_batch({session.record.id, session.record.robot}, batch.events,
                       [&] { return session.view(); });
  }
  return BatchOutcome{.answer = answer};
}

Result<void> LocalizationService::save(LiveSession& session) {
  if (!checkpoints_) return store(session);
  checkpoints_->add(session);
  return {};
}

Result<void> LocalizationService::store(LiveSession& session) {
  const LocalizerState state = session.state();
  auto stored = group_commit_.store(session.change(state));
  if (stored) session.note_stored(state);
  return stored;
}

Result<std::string> LocalizationService::localize(const std::string& map,
                                                  const api::LocalizeRequest& request) {
  const auto loaded = maps_->load(map);
  if (!loaded) return loaded.error();
  std::vector<LocalizationMapPtr> maps;
  if ((*loaded)->grid().width > 0) maps.push_back(*loaded);
  Localizer localizer(std::move(maps), request.params, settings_.clock_ms);
  std::optional<double> search_begin;
  const ProcessedBatch batch =
      process_batch(localizer, Status::kCollecting, request.scans, search_begin).value();
  return settings_.render({.session = {},
                           .sequence = std::nullopt,
                           .stamp = request.scans.back().scan.stamp,
                           .answer = batch.answer});
}

Result<LocalizationService::LockedSession> LocalizationService::lock(const std::string& id) {
  const auto now = SessionTable::Clock::now();
  if (table_.forget_idle(now, settings_.idle_time)) remove_expired();
  const auto epoch = stores_->epoch(id);
  if (!epoch) return epoch.error();
  LockedSession locked(table_.take(id, now));
  locked->record.id = id;
  if (!locked->is_current || locked->epoch != *epoch) {
    if (auto loaded = refresh(*locked); !loaded) {
      locked->is_current = false;
      if (loaded.error().code == ErrorCode::kNotFound) table_.forget(id);
      return loaded.error();
    }
    locked->epoch = *epoch;
  }
  return locked;
}

Result<void> LocalizationService::refresh(LiveSession& session) {
  const std::string id = session.record.id;
  if (session.unstored_since && session.is_whole) {
    const auto stored = store(session);
    session.is_current = session.is_current || stored;
    if (stored) return {};
    const ErrorCode code = stored.error().code;
    if (code != ErrorCode::kConflict && code != ErrorCode::kNotFound) return stored.error();
  }
  auto found = stores_->with_sessions([&](SessionStore& sessions) { return sessions.find(id); });
  if (!found) return found.error();
  if (!found->has_value()) return no_such_session(id);
  SessionRecord& record = **found;
  if (session.is_same_as(record)) return {};
  auto lidars = api::lidars_from_json(record.lidar_json);
  if (!lidars)
    return Error{ErrorCode::kCorruptData, "session " + id + " has a wrong lidar", "session"};
  session.load(std::move(record), std::move(*lidars));
  return {};
}

void LocalizationService::remove_expired() {
  if (!settings_.expired_before) return;
  const std::string time = settings_.expired_before();
  const auto removed = stores_->with_sessions(
      [&](SessionStore& sessions) { return sessions.remove_unused_since(time); });
  if (!removed) spdlog::warn("expired sessions could not be removed: {}", removed.error().message);
  if (removed && *removed > 0) spdlog::info("removed {} expired sessions", *removed);
}

}  // namespace cornerfix::server

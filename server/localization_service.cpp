#include "server/localization_service.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <map>
#include <random>
#include <utility>

#include "server/batch_digest.hpp"
#include "server/session_maps.hpp"

namespace cornerfix::server {

using storage::MapInfo;
using storage::MapStore;
using storage::SessionRecord;
using storage::SessionStore;
using SteadyClock = std::chrono::steady_clock;

namespace {

constexpr std::size_t kMapsAPage = 1000;
constexpr int kMaxAttempts = 3;
constexpr std::chrono::seconds kSweepInterval{30};
/// Of a session with its localizer, as measured: its submap, and while it searches, what it has
/// looked at (docs/reliability.md, section 5).
constexpr std::size_t kTrackingBytes = 1'500'000;
constexpr std::size_t kSearchingBytes = 3'000'000;

/// 128 random bits: nobody guesses another robot's session.
std::string make_session_id() {
  std::random_device random;
  std::string id;
  for (int word = 0; word < 4; ++word) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::uint32_t bits = random();
    for (int digit = 0; digit < 8; ++digit, bits >>= 4U) id += kDigits[bits & 15U];
  }
  return id;
}

/// Stamps within a batch increase already; a batch must also begin after the one before it.
/// Scans of two lidars may have the same stamp.
std::optional<Error> check_stamp(const RobotScan& first, std::optional<double> last_stamp,
                                 const api::Lidars& lidars) {
  if (!last_stamp || first.scan.stamp > *last_stamp) return std::nullopt;
  if (lidars.by_name.size() > 1 && first.scan.stamp == *last_stamp) return std::nullopt;
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("stamp {} is not after {}, the session's last", first.scan.stamp, *last_stamp),
      "/scans/0/stamp"};
}

void add(StepTimes& sum, const StepTimes& times) {
  sum.odometry_ms += times.odometry_ms;
  sum.extract_ms += times.extract_ms;
  sum.match_ms += times.match_ms;
  sum.verify_ms += times.verify_ms;
  sum.track_ms += times.track_ms;
  sum.total_ms += times.total_ms;
}

struct ProcessedBatch {
  Answer answer;  ///< To the last scan, with the times of all.
  BatchEvents events;
};

/// Called before each scan but the first, with the answer to the one before it.
using BetweenScans = std::function<Result<void>(const Answer&)>;

Result<ProcessedBatch> process(Localizer& localizer, Status status,
                               std::span<const RobotScan> scans,
                               std::optional<double>& search_begin,
                               const BetweenScans& between_scans = {}) {
  ProcessedBatch batch;
  StepTimes times;
  for (const RobotScan& scan : scans) {
    if (status != Status::kLocalized && !search_begin) search_begin = scan.scan.stamp;
    if (between_scans && batch.events.scans > 0) {
      if (auto ready = between_scans(batch.answer); !ready) return ready.error();
    }
    batch.answer = localizer.process(scan);
    add(times, batch.answer.times);
    ++batch.events.scans;
    if (batch.answer.withdrawal != Withdrawal::kNone)
      ++batch.events.withdrawals[batch.answer.withdrawal];
    batch.events.odometry_ignored += batch.answer.odometry == OdometryUse::kIgnored ? 1U : 0U;
    if (batch.answer.status != status) {
      batch.events.fixes += batch.answer.status == Status::kLocalized ? 1U : 0U;
      batch.events.lost += batch.answer.status == Status::kLost ? 1U : 0U;
    }
    status = batch.answer.status;
    if (status == Status::kLocalized && search_begin) {
      batch.events.times_to_localization_s.push_back(scan.scan.stamp - *search_begin);
      search_begin.reset();
    }
  }
  batch.answer.times = times;
  batch.events.status = status;
  batch.events.reason = batch.answer.reason;
  batch.events.times = times;
  return batch;
}

/// The newest scan of the local map, as it lies from the last pose: what can be shown of a session
/// that was read from the store.
std::optional<RobotScan> newest_scan(const LocalizerState& state) {
  if (state.submap.empty()) return std::nullopt;
  const SubmapScan& newest = state.submap.back();
  const Pose2 T_base_link_then = inverse(state.T_submap_base_link) * newest.T_submap_base_link;
  return RobotScan{.scan = newest.scan,
                   .T_base_link_laser = T_base_link_then * newest.T_base_link_laser,
                   .T_odom_base_link = std::nullopt};
}

/// Id of the newest session of a robot, if that is another one than `id`; else empty.
Result<std::string> superseding(SessionStore& sessions, const std::string& robot,
                                const std::string& id) {
  auto newest = sessions.newest(robot);
  if (newest && *newest == id) newest->clear();
  return newest;
}

Error no_such_session(const std::string& id) {
  return {ErrorCode::kNotFound, "there is no session " + id, ""};
}

}  // namespace

/// A session in memory. A localizer knows its tracked map by its place in a list; `map_ids` is that
/// list. In the store and in `stored_state` it is the map's id itself, because by the time it is
/// read the list may be another.
struct LocalizationService::Session {
  explicit Session(std::atomic<std::size_t>& live_bytes) : live_bytes_(live_bytes) {}
  ~Session() { drop_localizer(); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  std::mutex mutex;
  SessionRecord record;  ///< Without the state.
  api::Lidars lidars;
  LocalizerParams params;
  std::atomic<Status> status = Status::kCollecting;  ///< Counted without the mutex.
  std::atomic<std::size_t> bytes = 0;                ///< Of the localizer; read without the mutex.
  LocalizerState stored_state;                       ///< What the next localizer goes on from;
                                                     ///< empty while there is one.
  std::optional<Localizer> localizer;  ///< Made when the first batch comes; ahead of the above.
  std::vector<std::int64_t> map_ids;   ///< In the localizer's order.
  bool holds_all_maps = false;         ///< False: stand-ins for all but the tracked one.
  double free_area_m2 = 0.0;           ///< Of all maps, as far as it is known.
  std::int64_t confirmed_map = 0;      ///< In which a confirmed pose is tracked, or 0.
  std::optional<double> search_begin;  ///< Stamp of the first scan of a search, while it lasts.
  bool is_answered = false;            ///< Since it was made or reset.
  std::optional<RobotScan> last_scan;
  std::vector<Point2> feature_points;
  api::AnswerHistory history;
  std::map<std::string, std::int64_t> ids_by_name;  ///< Of the maps asked for, once seen.
  bool is_current = false;            ///< False: to be read from the store before use.
  std::uint64_t epoch = 0;            ///< Of the store when it was last known to be current.
  std::uint64_t maps_epoch = 0;       ///< Of the store when the localizer's maps were.
  SteadyClock::time_point last_used;  ///< Guarded by the table's mutex.

  [[nodiscard]] SessionView view() const {
    return {.id = record.id,
            .robot = record.robot,
            .created = record.created,
            .last_seen = record.last_used,
            .maps = record.maps,
            .lidar_json = record.lidar_json,
            .options_json = record.options_json,
            .region = localizer ? localizer->region() : stored_state.region,
            .expected_sequence = record.expected_sequence,
            .status = status,
            .last_answer = is_answered ? record.last_answer : std::string(),
            .last_scan = last_scan,
            .feature_points = feature_points};
  }

  [[nodiscard]] std::optional<double> last_stamp() const {
    return localizer ? localizer->last_stamp() : stored_state.last_stamp;
  }

  [[nodiscard]] LocalizerState state() const {
    if (!localizer) return stored_state;
    LocalizerState state = localizer->state();
    if (state.tracked_map >= 0) {
      state.tracked_map = static_cast<int>(map_ids[static_cast<std::size_t>(state.tracked_map)]);
    }
    return state;
  }

  /// What the next scan needs: a confirmed pose is not compared with other maps again.
  void note_confirmed(const Answer& answer) {
    confirmed_map = 0;
    if (!answer.pose || !answer.pose->confirmed) return;
    const auto found = std::ranges::find(localizer->maps(), answer.pose->map);
    confirmed_map = map_ids[static_cast<std::size_t>(found - localizer->maps().begin())];
  }

  void note_confirmed(const LocalizerState& state) {
    const bool is_confirmed = state.status == Status::kLocalized && state.confirmed;
    confirmed_map = is_confirmed && state.tracked_map > 0 ? state.tracked_map : 0;
  }

  /// Goes on in these maps. When the tracked one is not among them, the robot is lost.
  void use_maps(SessionMaps loaded, const Localizer::Clock& clock) {
    std::vector<LocalizationMapPtr> maps = std::move(loaded.maps);
    std::vector<std::int64_t> ids = std::move(loaded.ids);
    holds_all_maps = loaded.holds_all;
    free_area_m2 = loaded.free_area_m2;
    if (localizer && ids == map_ids) {
      if (maps != localizer->maps()) localizer->replace_maps(std::move(maps));
      return;
    }
    LocalizerState state = localizer ? this->state() : std::exchange(stored_state, {});
    if (state.tracked_map >= 0) {
      const auto found = std::ranges::find(ids, std::int64_t{state.tracked_map});
      const bool is_there = found != ids.end();
      state.tracked_map = is_there ? static_cast<int>(found - ids.begin()) : -1;
      if (!is_there) state.region.reset();
      if (!is_there && state.status == Status::kLocalized) state.status = Status::kLost;
    }
    status = state.status;
    localizer.emplace(std::move(maps), params, clock);
    localizer->restore(std::move(state));
    map_ids = std::move(ids);
    count_bytes();
  }

  void drop_localizer() {
    localizer.reset();
    map_ids.clear();
    count_bytes();
  }

  /// To be called when `localizer` or `status` changed.
  void count_bytes() {
    const std::size_t live = status == Status::kLocalized ? kTrackingBytes : kSearchingBytes;
    const std::size_t now = localizer ? live : 0;
    live_bytes_ += now - bytes;  // Wraps around where it shrinks.
    bytes = now;
  }

 private:
  std::atomic<std::size_t>& live_bytes_;  ///< Of all sessions.
};

/// A session held for this thread alone.
class LocalizationService::LockedSession {
 public:
  explicit LockedSession(std::shared_ptr<Session> session)
      : session_(std::move(session)), lock_(session_->mutex) {}
  Session& operator*() const { return *session_; }
  Session* operator->() const { return session_.get(); }

 private:
  std::shared_ptr<Session> session_;
  std::unique_lock<std::mutex> lock_;
};

LocalizationService::LocalizationService(std::shared_ptr<StoreAccess> stores,
                                         std::shared_ptr<MapLibrary> maps,
                                         LocalizationServiceSettings settings)
    : stores_(std::move(stores)), maps_(std::move(maps)), settings_(std::move(settings)) {}

LocalizationService::~LocalizationService() = default;

Result<std::optional<SessionView>> LocalizationService::create(
    const api::CreateSessionRequest& request) {
  std::vector<std::int64_t> map_ids;
  for (const std::string& map : request.maps) {
    const auto info = maps_->find(map);
    if (!info) return info.error();
    map_ids.push_back(info->id);
  }
  if (auto good = check_region(request.region, request.maps); !good) return good.error();
  LocalizerState state;
  state.region = request.region;
  const std::string now = settings_.now();
  const SessionRecord record{.id = make_session_id(),
                             .robot = request.robot,
                             .created = now,
                             .maps = request.maps,
                             .lidar_json = request.lidar_json,
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
    has_room = *count < settings_.max_sessions_per_robot;
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

Result<SessionView> LocalizationService::view_of(const Session& session) {
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

SessionCounts LocalizationService::count_by_status() {
  SessionCounts counts{};
  const std::lock_guard lock(table_mutex_);
  for (const auto& [id, session] : table_) {
    ++counts[static_cast<std::size_t>(session->status.load())];
  }
  return counts;
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
    list.sessions.push_back({.id = std::move(record.id),
                             .robot = std::move(record.robot),
                             .created = std::move(record.created),
                             .last_seen = record.last_used,
                             .is_stale = is_stale(record.last_used),
                             .superseded_by = std::move(superseded_by[i]),
                             .maps = std::move(record.maps),
                             .lidar_json = std::move(record.lidar_json),
                             .options_json = std::move(record.options_json),
                             .region = std::move(record.state.region),
                             .expected_sequence = record.expected_sequence,
                             .status = record.state.status,
                             .last_answer = is_answered ? std::move(record.last_answer) : ""});
  }
  return list;
}

Result<void> LocalizationService::remove(const std::string& id) {
  forget(id);
  return stores_->with_sessions([&](SessionStore& sessions) { return sessions.remove(id); });
}

Result<void> LocalizationService::check_region(const std::optional<StartRegion>& region,
                                               const std::vector<std::string>& maps) {
  if (!region || region->map.empty()) return {};
  if (maps.empty()) {
    const auto info = maps_->find(region->map);
    return info ? Result<void>() : Result<void>(info.error());
  }
  if (std::ranges::find(maps, region->map) != maps.end()) return {};
  return Error{ErrorCode::kInvalidArgument, "must be one of the session's maps", "/near/map"};
}

Result<SessionView> LocalizationService::reset(const std::string& id,
                                               const std::optional<StartRegion>& region) {
  for (int attempt = 1;; ++attempt) {
    const auto locked = lock(id);
    if (!locked) return locked.error();
    Session& session = **locked;
    if (auto good = check_region(region, session.record.maps); !good) return good.error();
    session.is_current = false;  // Until the store has it too.
    LocalizerState forgotten;
    forgotten.region = region;
    const std::string now = settings_.now();
    const storage::SessionUpdate update{.previous_sequence = session.record.expected_sequence,
                                        .expected_sequence = session.record.expected_sequence,
                                        .last_answer = session.record.last_answer,
                                        .state = &forgotten,
                                        .now = now,
                                        .last_batch = session.record.last_batch};
    const auto saved =
        stores_->with_sessions([&](SessionStore& sessions) { return sessions.update(id, update); });
    if (!saved && saved.error().code == ErrorCode::kConflict && attempt < kMaxAttempts) continue;
    if (!saved) return saved.error();
    if (session.localizer) session.localizer->reset(region);
    session.stored_state = std::move(forgotten);
    session.confirmed_map = 0;
    session.search_begin.reset();
    session.status = Status::kCollecting;
    session.is_answered = false;
    session.last_scan.reset();
    session.feature_points.clear();
    session.record.last_used = now;
    session.is_current = true;
    return view_of(session);
  }
}

Result<SessionHead> LocalizationService::head(const std::string& id) {
  const auto session = lock(id);
  if (!session) return session.error();
  return SessionHead{(*session)->record.robot, (*session)->lidars};
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
    Session& session = **locked;
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

Result<BatchOutcome> LocalizationService::take_batch(Session& session,
                                                     const api::SessionScansRequest& request) {
  if (auto ready = use_current_maps(session); !ready) return ready.error();
  const auto last_stamp = session.localizer->last_stamp();
  if (auto error = check_stamp(request.scans.front(), last_stamp, session.lidars)) return *error;

  session.is_current = false;  // Until the store has the batch too.
  std::optional<double> search_begin = session.search_begin;
  const auto prepare = [&](const Answer& answer) -> Result<void> {
    session.note_confirmed(answer);
    const bool is_ready = session.holds_all_maps || session.confirmed_map != 0;
    return is_ready ? Result<void>() : use_current_maps(session);
  };
  const auto processed =
      process(*session.localizer, session.status, request.scans, search_begin, prepare);
  if (!processed) return processed.error();
  const ProcessedBatch& batch = *processed;
  session.note_confirmed(batch.answer);
  const RobotScan& last = request.scans.back();
  const std::string answer = settings_.render({.session = session.record.id,
                                               .sequence = request.sequence,
                                               .stamp = last.scan.stamp,
                                               .answer = batch.answer});
  if (auto saved = save(session, request, answer); !saved) return saved.error();
  session.history.add(batch.answer, request.sequence, session.record.last_used);
  session.status = batch.answer.status;
  session.count_bytes();
  session.search_begin = search_begin;
  session.is_answered = true;
  session.last_scan = last;
  session.feature_points = session.localizer->local_features_base_link();
  if (settings_.recorded_answers > 0)
    session.history.record({answer, last, session.feature_points}, settings_.recorded_answers);
  session.is_current = true;
  if (settings_.on_batch) {
    settings_.on_batch({session.record.id, session.record.robot}, batch.events,
                       [&] { return session.view(); });
  }
  return BatchOutcome{.answer = answer};
}

Result<void> LocalizationService::save(Session& session, const api::SessionScansRequest& request,
                                       const std::string& answer) {
  const LocalizerState state = session.state();
  const std::string now = settings_.now();
  const storage::SessionUpdate update{.previous_sequence = session.record.expected_sequence,
                                      .expected_sequence = request.sequence + 1,
                                      .last_answer = answer,
                                      .state = &state,
                                      .now = now,
                                      .last_batch = digest_of(request.scans)};
  auto saved = stores_->with_sessions(
      [&](SessionStore& sessions) { return sessions.update(session.record.id, update); });
  if (!saved) return saved;
  session.record.expected_sequence = update.expected_sequence;
  session.record.last_batch = update.last_batch;
  session.record.last_answer = answer;
  session.record.last_used = now;
  return {};
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
      process(localizer, Status::kCollecting, request.scans, search_begin).value();
  return settings_.render({.session = {},
                           .sequence = std::nullopt,
                           .stamp = request.scans.back().scan.stamp,
                           .answer = batch.answer});
}

Result<LocalizationService::LockedSession> LocalizationService::lock(const std::string& id) {
  const auto now = SteadyClock::now();
  forget_idle(now);
  const auto epoch = stores_->epoch(id);
  if (!epoch) return epoch.error();
  std::shared_ptr<Session> session;
  {
    const std::lock_guard lock(table_mutex_);
    std::shared_ptr<Session>& entry = table_[id];
    if (!entry) entry = std::make_shared<Session>(live_bytes_);
    entry->last_used = now;
    session = entry;
  }
  LockedSession locked(std::move(session));
  locked->record.id = id;
  if (!locked->is_current || locked->epoch != *epoch) {
    if (auto loaded = refresh(*locked); !loaded) {
      locked->is_current = false;
      if (loaded.error().code == ErrorCode::kNotFound) forget(id);
      return loaded.error();
    }
    locked->epoch = *epoch;
  }
  return locked;
}

Result<void> LocalizationService::refresh(Session& session) {
  const std::string id = session.record.id;
  auto found = stores_->with_sessions([&](SessionStore& sessions) { return sessions.find(id); });
  if (!found) return found.error();
  if (!found->has_value()) return no_such_session(id);
  SessionRecord& record = **found;
  // Every batch raises the one number and a reset zeroes the other: both the same, nobody was here.
  const bool is_unchanged = session.is_current && session.localizer &&
                            record.expected_sequence == session.record.expected_sequence &&
                            record.state.scans == session.localizer->state().scans &&
                            record.state.region == session.localizer->region();
  if (is_unchanged) return {};
  auto lidars = api::lidars_from_json(record.lidar_json);
  if (!lidars) return Error{ErrorCode::kCorruptData, "session " + id + " has a wrong lidar", ""};
  session.lidars = std::move(*lidars);
  session.params = api::params_from_json(record.options_json);
  session.stored_state = std::exchange(record.state, {});
  session.record = std::move(record);
  for (std::size_t i = 0; i < session.record.maps.size(); ++i) {
    const std::int64_t map_id = session.record.map_ids[i];
    if (map_id > 0) session.ids_by_name.try_emplace(session.record.maps[i], map_id);
  }
  session.status = session.stored_state.status;
  session.note_confirmed(session.stored_state);
  session.drop_localizer();
  session.is_answered = session.stored_state.scans > 0;
  session.last_scan = newest_scan(session.stored_state);
  session.feature_points.clear();
  session.is_current = true;
  return {};
}

Result<void> LocalizationService::use_current_maps(Session& session) {
  const bool is_current = session.localizer && session.maps_epoch == session.epoch &&
                          session.holds_all_maps == (session.confirmed_map == 0);
  if (is_current) return {};
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
  park_least_used();
  return {};
}

Result<std::vector<MapInfo>> LocalizationService::maps_of(Session& session) {
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

void LocalizationService::forget(const std::string& id) {
  const std::lock_guard lock(table_mutex_);
  table_.erase(id);
}

void LocalizationService::forget_idle(SteadyClock::time_point now) {
  {
    const std::lock_guard lock(table_mutex_);
    if (now < next_sweep_) return;
    next_sweep_ = now + kSweepInterval;
    // One in use is held by its user too.
    std::erase_if(table_, [&](const auto& entry) {
      const auto& session = entry.second;
      return session.use_count() == 1 && now - session->last_used > settings_.idle_time;
    });
  }
  remove_expired();
}

void LocalizationService::remove_expired() {
  if (!settings_.expired_before) return;
  const std::string time = settings_.expired_before();
  const auto removed = stores_->with_sessions(
      [&](SessionStore& sessions) { return sessions.remove_unused_since(time); });
  if (!removed) spdlog::warn("expired sessions could not be removed: {}", removed.error().message);
  if (removed && *removed > 0) spdlog::info("removed {} expired sessions", *removed);
}

/// Leaves a tenth of the room free, so that not every batch has to look.
void LocalizationService::park_least_used() {
  if (live_bytes_ <= settings_.max_session_bytes) return;
  const std::lock_guard lock(table_mutex_);
  std::vector<std::pair<SteadyClock::time_point, std::string>> parkable;
  for (const auto& [id, session] : table_) {
    // One in use is held by its user too.
    if (session->bytes > 0 && session.use_count() == 1)
      parkable.emplace_back(session->last_used, id);
  }
  std::ranges::sort(parkable);
  const std::size_t wanted = settings_.max_session_bytes - settings_.max_session_bytes / 10;
  for (const auto& [last_used, id] : parkable) {
    if (live_bytes_ <= wanted) return;
    table_.erase(id);
  }
}

}  // namespace cornerfix::server

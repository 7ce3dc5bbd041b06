/// \file  The use cases on robots: sessions that take batch after batch, and single questions.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/localizer.hpp>
#include <cornerfix/result.hpp>

#include "api/answer_history.hpp"
#include "api/requests.hpp"
#include "server/batch_processing.hpp"
#include "server/checkpoints.hpp"
#include "server/group_commit.hpp"
#include "server/live_session.hpp"
#include "server/map_library.hpp"
#include "server/map_ranking.hpp"
#include "server/ranked_map_source.hpp"
#include "server/session_table.hpp"
#include "server/store_access.hpp"

namespace cornerfix::server {

/// An answer before it is rendered.
struct AnswerToRender {
  std::string_view session;               ///< Empty for a single question.
  std::optional<std::uint64_t> sequence;  ///< Of the batch; nothing for a single question.
  double stamp = 0.0;                     ///< Of the last scan [s].
  const Answer& answer;
};
using AnswerRenderer = std::function<std::string(const AnswerToRender&)>;

/// Which robot posted a batch, in which session.
struct BatchOrigin {
  const std::string& session;
  const std::string& robot;
};
/// Called while the session is held; `view` makes the view, which costs a copy.
using BatchListener = std::function<void(const BatchOrigin&, const BatchEvents&,
                                         const std::function<SessionView()>& view)>;

/// What is needed to read a session's batch.
struct SessionHead {
  std::string robot;
  api::Lidars lidars;
};

/// What came of a batch.
struct BatchOutcome {
  /// Set when the batch was not the next one: nothing was done, and this one is awaited.
  std::optional<std::uint64_t> expected_sequence{};
  /// Its sequence was that of the last batch, but its scans were others: nothing was done.
  bool is_another_batch = false;
  std::optional<double> last_stamp{};  ///< Of the last scan that was taken, beside the above [s].
  std::string answer{};  ///< Rendered; the same bytes whenever the batch is posted again.
};

struct LocalizationServiceSettings {
  AnswerRenderer render;
  NowText now;
  Localizer::Clock clock_ms;           ///< For the timing in answers; may be empty.
  BatchListener on_batch;              ///< Called after a batch was stored; may be empty.
  std::chrono::minutes idle_time{30};  ///< Then a session is kept in the store only.
  /// Of sessions in memory. Above it those not used for longest are kept in the store only.
  std::size_t max_session_bytes = std::size_t{2} << 30U;
  std::size_t max_sessions = 100'000;
  std::size_t max_sessions_per_robot = 100;
  /// Of the maps that one session searches together.
  std::size_t max_searched_map_bytes = std::size_t{4} << 30U;
  /// A session in any map searches all of so many; of more, those that a ranking chooses.
  std::size_t max_maps_without_ranking = 4;
  std::size_t recorded_answers = 0;  ///< Of a session's history, kept with their scans.
  NowText expired_before{};  ///< Sessions last used before this time are removed; may be empty.
  NowText stale_before{};    ///< Sessions last used before this time are stale; may be empty.
  /// Zero: a batch is stored before its answer. Else sessions are stored by Checkpoints.
  std::chrono::milliseconds checkpoint_interval{0};
};

/// Which sessions to list.
struct SessionListRequest {
  std::string robot{};     ///< Its sessions only; empty: those of all robots.
  std::int64_t after = 0;  ///< `next` of the page before.
  std::size_t limit = 1000;
};

struct SessionList {
  std::vector<SessionView> sessions;   ///< By creation.
  std::optional<std::int64_t> next{};  ///< Set when there are more.
};

/// Sessions live in memory while robots post, and in the store always: what was answered survives
/// the process, but for the batches of the last `checkpoint_interval`. Several processes may serve
/// the same file. Batches of one session are taken
/// one after the other, those of different ones side by side. A call that fails changes nothing.
/// Any threads may call.
class LocalizationService {
 public:
  /// Without a `ranking` a session in any map searches all of them, however many there are.
  LocalizationService(std::shared_ptr<StoreAccess> stores, std::shared_ptr<MapLibrary> maps,
                      LocalizationServiceSettings settings,
                      std::shared_ptr<MapRanking> ranking = nullptr);
  ~LocalizationService();

  /// kNotFound when a map is unknown. Nothing when there are as many sessions, or the robot has as
  /// many, as there may be.
  [[nodiscard]] Result<std::optional<SessionView>> create(const api::CreateSessionRequest& request);
  [[nodiscard]] Result<SessionView> find(const std::string& id);
  /// The same while the session is held: no batch is answered until `look` returns.
  [[nodiscard]] Result<void> visit(const std::string& id,
                                   const std::function<void(const SessionView&)>& look);
  [[nodiscard]] Result<SessionList> list(const SessionListRequest& request);
  /// Those in memory only.
  [[nodiscard]] SessionCounts count_by_status() { return table_.count_by_status(); }
  [[nodiscard]] Result<void> remove(const std::string& id);
  /// The robot was carried: forgets the pose, the submap and the stamps; the sequence goes on.
  /// The robot is in `region` now, if there is one.
  [[nodiscard]] Result<SessionView> reset(const std::string& id,
                                          const std::optional<StartRegion>& region = {});

  [[nodiscard]] Result<SessionHead> head(const std::string& id);
  /// Its robot, also when what is stored of its state is damaged. kNotFound.
  [[nodiscard]] Result<std::string> robot_of(const std::string& id);

  /// The last answers, oldest first, as far as this process gave them and holds the session.
  [[nodiscard]] Result<std::deque<api::PastAnswer>> history(const std::string& id);

  /// kConflict when the session's map was deleted, kInvalidArgument when stamps do not increase.
  [[nodiscard]] Result<BatchOutcome> post_scans(const std::string& id,
                                                const api::SessionScansRequest& request);

  /// One question without a session: the rendered answer. kNotFound for an unknown map.
  [[nodiscard]] Result<std::string> localize(const std::string& map,
                                             const api::LocalizeRequest& request);

  /// Stores what was acknowledged and is not stored yet, but for sessions within a batch. Returns
  /// how many sessions could not be stored.
  [[nodiscard]] std::size_t store_all() { return checkpoints_ ? checkpoints_->store_all() : 0; }

 private:
  class LockedSession;

  [[nodiscard]] bool is_stale(const std::string& last_seen) const;
  [[nodiscard]] Result<SessionView> view_of(const LiveSession& session);
  [[nodiscard]] Result<LockedSession> lock(const std::string& id);
  [[nodiscard]] Result<void> refresh(LiveSession& session);
  [[nodiscard]] Result<void> use_current_maps(LiveSession& session);
  /// Whether the session's maps come from the ranking, as it is now.
  [[nodiscard]] Result<bool> is_in_ranked_maps(const LiveSession& session);
  [[nodiscard]] Result<void> use_ranked_maps(LiveSession& session);
  /// The present revisions of the maps that the session's localizer holds; nothing when one of them
  /// is gone.
  [[nodiscard]] Result<std::optional<std::vector<LocalizationMapPtr>>> current_revisions(
      const LiveSession& session);
  [[nodiscard]] Result<LocalizationMapPtr> load_ranked(MapKey key);
  [[nodiscard]] Result<std::vector<storage::MapInfo>> maps_of(LiveSession& session);
  [[nodiscard]] Result<std::vector<storage::MapInfo>> every_map();
  [[nodiscard]] Result<BatchOutcome> take_batch(LiveSession& session,
                                                const api::SessionScansRequest& request);
  /// Stores the session, or sees to it that it will be.
  [[nodiscard]] Result<void> save(LiveSession& session);
  [[nodiscard]] Result<void> store(LiveSession& session);
  void remove_expired();

  std::shared_ptr<StoreAccess> stores_;
  std::shared_ptr<MapLibrary> maps_;
  std::shared_ptr<MapRanking> ranking_;
  std::shared_ptr<RankedMapSource> ranked_maps_;  ///< Null without a ranking.
  LocalizationServiceSettings settings_;
  SessionTable table_;
  GroupCommit group_commit_;
  std::unique_ptr<Checkpoints> checkpoints_;  ///< Null without an interval. Ends first.
};

}  // namespace cornerfix::server

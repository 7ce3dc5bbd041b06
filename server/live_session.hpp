/// \file  A session in memory.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <cornerfix/localizer.hpp>

#include "api/answer_history.hpp"
#include "api/requests.hpp"
#include "server/session_maps.hpp"
#include "storage/session_store.hpp"

namespace cornerfix::server {

/// A session as others see it.
struct SessionView {
  std::string id;
  std::string robot;
  std::string created;    ///< RFC 3339, UTC.
  std::string last_seen;  ///< When it took its last batch, was reset or created.
  bool is_stale = false;  ///< Not seen for long: what it answered last is old.
  /// Id of the newest session of the robot, if that is another one.
  std::string superseded_by{};
  std::vector<std::string> maps;  ///< As asked for; empty: every map.
  api::Lidars lidars;
  LocalizerParams params;
  std::optional<StartRegion> region{};  ///< While it restricts the search.
  std::uint64_t expected_sequence = 0;
  Status status = Status::kCollecting;
  std::string last_answer;  ///< Rendered; empty before the first, also after a reset.
  /// Of the last batch; after a restart the newest scan of the local map, as seen from the last
  /// pose.
  std::optional<RobotScan> last_scan{};
  std::vector<Point2> feature_points{};  ///< The submap's features, in base_link at the last scan.
  bool is_damaged = false;               ///< What is stored of its state cannot be read.
};

/// A localizer knows its tracked map by its place in a list; `map_ids` is that list. In the store
/// and in `stored_state` it is the map's id itself, because by the time it is read the list may be
/// another. Guarded by `mutex` where nothing else is said.
struct LiveSession : std::enable_shared_from_this<LiveSession> {
  explicit LiveSession(std::atomic<std::size_t>& live_bytes) : live_bytes_(live_bytes) {}
  ~LiveSession() { drop_localizer(); }
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  std::mutex mutex;
  storage::SessionRecord record;  ///< Without the state.
  api::Lidars lidars;
  LocalizerParams params;
  std::atomic<Status> status = Status::kCollecting;  ///< Counted without the mutex.
  std::atomic<std::size_t> bytes = 0;                ///< Of the localizer; read without the mutex.
  LocalizerState stored_state;                       ///< What the next localizer goes on from;
                                                     ///< empty while there is one.
  std::optional<Localizer> localizer;  ///< Made when the first batch comes; ahead of the above.
  std::vector<std::int64_t> map_ids;   ///< In the localizer's order; empty with a source.
  bool is_ranked = false;              ///< The localizer has a source of ranked maps.
  bool holds_all_maps = false;         ///< False: stand-ins for all but the tracked one.
  double free_area_m2 = 0.0;           ///< Of all maps, as far as it is known.
  std::int64_t confirmed_map = 0;      ///< In which a confirmed pose is tracked, or 0.
  std::optional<double> search_begin;  ///< Stamp of the first scan of a search, while it lasts.
  bool is_answered = false;            ///< Since it was made or reset.
  bool is_searching = false;           ///< A search goes on with the next scan.
  std::optional<RobotScan> last_scan;
  std::vector<Point2> feature_points;
  api::AnswerHistory history;
  std::map<std::string, std::int64_t> ids_by_name;  ///< Of the maps asked for, once seen.
  bool is_current = false;            ///< False: to be read from the store before use.
  bool is_whole = false;              ///< False: the localizer is within a batch that did not end.
  std::uint64_t stored_sequence = 0;  ///< `expected_sequence` and the state's `scans` as they are
  std::uint64_t stored_scans = 0;     ///< in the store.
  /// When the first batch was acknowledged that the store does not have yet.
  std::optional<std::chrono::steady_clock::time_point> unstored_since;
  std::uint64_t epoch = 0;            ///< Of the store when it was last known to be current.
  std::uint64_t maps_epoch = 0;       ///< Of the store when the localizer's maps were.
  std::uint64_t ranking_version = 0;  ///< Of the ranking when the localizer's maps were current.
  std::chrono::steady_clock::time_point last_used;  ///< Guarded by the table's mutex.

  [[nodiscard]] SessionView view() const;
  [[nodiscard]] std::optional<double> last_stamp() const;
  [[nodiscard]] LocalizerState state() const;

  /// What brings the store to what is in memory; views of it live as long as this and `state`.
  [[nodiscard]] storage::SessionChange change(const LocalizerState& state) const;
  /// The store has taken change(state).
  void note_stored(const LocalizerState& state);
  /// What is in memory is no longer right: it is read from the store before use.
  void discard();

  /// Whether the store has what is in memory.
  [[nodiscard]] bool is_same_as(const storage::SessionRecord& stored) const;
  /// Goes on from what was stored.
  void load(storage::SessionRecord stored, api::Lidars its_lidars);
  /// Starts anew, in `region` if there is one.
  void reset(LocalizerState forgotten, const std::string& now);

  /// What the next scan needs: a confirmed pose is not compared with other maps again.
  void note_confirmed(const Answer& answer);

  /// Goes on in these maps. When the tracked one is not among them, the robot is lost.
  void use_maps(SessionMaps loaded, const Localizer::Clock& clock);
  /// Goes on in the maps of a source. When it has not the tracked one, the robot is lost.
  void use_source(std::shared_ptr<MapSource> source, const Localizer::Clock& clock);
  /// Id of the tracked map, or -1.
  [[nodiscard]] std::int64_t tracked_map() const;
  /// Of the localizer's maps, in its order.
  [[nodiscard]] const std::vector<std::int64_t>& held_map_ids() const {
    return is_ranked ? localizer->map_keys() : map_ids;
  }

  [[nodiscard]] bool is_tracking() const { return status == Status::kLocalized; }
  /// Whether the store has all that is needed to go on without the localizer.
  [[nodiscard]] bool can_release_localizer() const {
    return localizer && is_current && !unstored_since && !is_searching;
  }
  /// Its maps are free then; the session is read from the store before its next use.
  void release_localizer();

  void drop_localizer();
  /// To be called when `localizer` or `status` changed.
  void count_bytes();

 private:
  void note_confirmed(const LocalizerState& state);
  /// The localizer's state, or the stored one, for a localizer in other maps.
  [[nodiscard]] LocalizerState take_state();
  /// The map of the state as its place in `ids`; the robot is lost when it is not there.
  void find_tracked(LocalizerState& state, const std::vector<std::int64_t>& ids);

  std::atomic<std::size_t>& live_bytes_;  ///< Of all sessions.
};

}  // namespace cornerfix::server

/// \file  The use case on jobs: long work that is accepted, stored, and done in the background.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <cornerfix/result.hpp>

#include "server/map_library.hpp"
#include "server/store_access.hpp"
#include "server/work_progress.hpp"
#include "storage/job_store.hpp"
#include "storage/known_map.hpp"

namespace cornerfix::server {

/// What the work of a job gets.
struct JobTask {
  std::string map;
  /// The map that may be changed. Revision 0: there must be none.
  storage::KnownMap known_map;
  storage::JobInput input;
  WorkProgress progress;
};

/// kConflict: the map that a job was given for was deleted.
[[nodiscard]] Error lost_map(std::string_view name);

/// Does the work of one kind of job and returns its answer, a JSON document. It may be called again
/// for a job that another server began: the same input must lead to the same state.
using JobRunner = std::function<Result<std::string>(const JobTask&)>;
using JobRunners = std::map<std::string, JobRunner, std::less<>>;

struct JobServiceSettings {
  NowText now;
  /// Called when the work of a job ends here; may be empty.
  std::function<void(std::string_view kind, storage::JobStatus status, double seconds)> on_end{};
  NowText expired_before{};  ///< Jobs that finished before this time are removed; may be empty.
  storage::JobLimits limits{};
  /// A running job whose heartbeat stands still for so long is taken over.
  std::chrono::milliseconds lease{15'000};
  std::chrono::milliseconds heartbeat{1'000};  ///< Also between looks for new jobs.
  /// How long the job in work has after close(). Then it goes back into the queue, and what its
  /// thread still does is lost.
  std::chrono::milliseconds patience{500};
};

/// One thread of low priority does the jobs of the database, one after the other; other servers on
/// the same database do others. A second thread renews the lease of the job in work. A job whose
/// server dies is begun anew by another one, at most kMaxAttempts times. Any threads may call.
class JobService {
 public:
  static constexpr std::uint64_t kMaxAttempts = 3;
  static constexpr std::size_t kMaxWaiters = 4;  ///< Each holds a thread that answers requests.

  JobService(std::shared_ptr<StoreAccess> stores, JobRunners runners, JobServiceSettings settings);
  ~JobService();
  JobService(const JobService&) = delete;
  JobService& operator=(const JobService&) = delete;

  /// Stores a job. Nothing when too many wait, or too many bytes.
  [[nodiscard]] Result<std::optional<storage::JobRecord>> submit(
      std::string_view kind, std::string_view map,
      const std::map<std::string, storage::BlobView>& input,
      const std::optional<storage::JobMap>& known_map = {});
  [[nodiscard]] Result<storage::JobRecord> find(std::string_view id);
  [[nodiscard]] Result<std::vector<storage::JobRecord>> list(const storage::JobPage& page);
  [[nodiscard]] Result<std::string> answer(std::string_view id);
  [[nodiscard]] Result<storage::JobRecord> cancel(std::string_view id);
  /// The job when it is finished, or after `wait` at most as it is then. When kMaxWaiters wait, at
  /// once.
  [[nodiscard]] Result<storage::JobRecord> wait_for(std::string_view id, std::chrono::seconds wait);
  [[nodiscard]] Result<std::vector<storage::JobCount>> counts();

  /// No job is begun any more. The one in work is given up and goes back into the queue, also when
  /// its thread does not end.
  void close();

 private:
  using Clock = std::chrono::steady_clock;

  /// The job in work, under the mutex.
  struct Current {
    std::int64_t number = 0;
    Clock::time_point began = Clock::now();
    std::string stage{};
    double progress = 0.0;
    storage::LeaseState lease = storage::LeaseState::kHeld;
  };
  /// A heartbeat of another server, and since when it stands still.
  struct Sighting {
    std::uint64_t heartbeat = 0;
    Clock::time_point since;
  };

  void work();
  void keep_lease();
  /// Whether it is done: the database may be busy.
  [[nodiscard]] bool put_back(std::int64_t job);
  [[nodiscard]] std::optional<storage::JobRecord> claim();
  void remove_expired();
  [[nodiscard]] std::vector<storage::JobLease> expired_leases(
      const std::vector<storage::JobLease>& running);
  void run(const storage::JobRecord& job);
  [[nodiscard]] Result<std::string> answer_of(const storage::JobRecord& job);
  [[nodiscard]] bool note_progress(std::string_view stage, double share);
  void end(const storage::JobRecord& job, const Result<std::string>& answer);
  void finish(const storage::JobRecord& job, const storage::JobOutcome& outcome);
  [[nodiscard]] Result<storage::KnownMap> known_map(const storage::JobRecord& job,
                                                    const storage::JobInput& input);
  [[nodiscard]] Result<storage::JobRecord> wait_until(std::string_view id,
                                                      Clock::time_point deadline);

  std::shared_ptr<StoreAccess> stores_;
  const JobRunners runners_;
  const JobServiceSettings settings_;
  const std::string holder_;                    ///< This service, for other servers.
  std::map<std::int64_t, Sighting> sightings_;  ///< This and the next of the worker alone.
  Clock::time_point next_removal_{};

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Current> current_;
  bool has_news_ = false;  ///< A job was submitted here.
  std::size_t waiters_ = 0;
  std::uint64_t ended_ = 0;  ///< Jobs that ended here.
  bool must_renew_ = false;  ///< A job was cancelled here: it may be the one in work.
  bool closing_ = false;
  bool worker_ended_ = false;
  Clock::time_point closed_{};  ///< When `closing_` was set.
  std::thread keeper_;
  std::thread worker_;
};

}  // namespace cornerfix::server

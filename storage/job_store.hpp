/// \file  Long work that was accepted and is done later, with all that it needs: jobs.
///
/// A job belongs to the server that claimed it as long as that server renews its lease. Leases have
/// no time of day: a server that sees the same heartbeat for long enough by its own clock may take
/// the job over. So clocks of servers need not agree.
///
/// Every call is one transaction; not synchronised (one thread at a time).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/result.hpp>

#include "storage/blob_codec.hpp"

namespace cornerfix::storage {

class Database;

enum class JobStatus { kQueued, kRunning, kSucceeded, kFailed, kCancelled };

inline constexpr std::array kJobStatuses = {JobStatus::kQueued, JobStatus::kRunning,
                                            JobStatus::kSucceeded, JobStatus::kFailed,
                                            JobStatus::kCancelled};

/// "queued", "running", "succeeded", "failed" or "cancelled".
[[nodiscard]] std::string_view to_string(JobStatus status);
[[nodiscard]] inline bool is_finished(JobStatus status) { return status > JobStatus::kRunning; }

/// A job without its input and its answer.
struct JobRecord {
  std::int64_t number = 0;  ///< In the order of acceptance; never used again.
  std::string id{};         ///< For clients.
  std::string kind{};       ///< As the server spells it; opaque here.
  std::string map{};        ///< Name of the map that it is about.
  JobStatus status = JobStatus::kQueued;
  std::string stage{};          ///< Of the work; empty before it begins.
  double progress = 0.0;        ///< In [0, 1].
  std::string created{};        ///< RFC 3339, UTC; so are the next two.
  std::string started{};        ///< The last time that a server claimed it; empty before.
  std::string finished{};       ///< Empty before.
  std::string problem{};        ///< Of a job that failed: a problem document, byte for byte.
  bool is_cancelling = false;   ///< Somebody cancelled it while it was running.
  std::uint64_t attempts = 0;   ///< Servers that claimed it and neither finished nor released it.
  std::string holder{};         ///< The server that runs it.
  std::uint64_t heartbeat = 0;  ///< Grows whenever the holder claims it or renews its lease.
};

/// By name, bytes that a job works on.
using JobInput = std::map<std::string, Blob>;

/// The map that a job is about, as the client knew it.
struct JobMap {
  std::uint64_t revision = 0;  ///< 0: there was none.
  std::int64_t id = 0;         ///< 0: there was none.
  /// The revision holds also where earlier jobs of the map are not finished. Else the job changes
  /// what they leave.
  bool is_required = false;
};

/// The revision of the map that the job may change; nothing where earlier jobs of the map were not
/// finished when it was accepted, and it did not begin yet.
[[nodiscard]] std::optional<std::uint64_t> map_revision(const JobInput& input);
/// Of the map that the job is about; 0 where there was none.
[[nodiscard]] std::int64_t map_id(const JobInput& input);

struct NewJob {
  std::string id;
  std::string kind;
  std::string map;
  std::string created;
  std::map<std::string, BlobView> input{};  ///< As JobInput.
  std::optional<JobMap> known_map{};        ///< Nothing: any.
};

/// Of jobs that are not finished.
struct JobLimits {
  std::size_t jobs = 100;
  std::uint64_t bytes = std::uint64_t{1} << 30U;  ///< Of their inputs.
};

/// Jobs of one kind and status.
struct JobCount {
  std::string kind;
  JobStatus status = JobStatus::kQueued;
  std::size_t jobs = 0;
};

struct JobPage {
  std::int64_t after = 0;  ///< Number of the last job of the page before.
  std::size_t limit = 100;
};

/// A running job as another server last saw it.
struct JobLease {
  std::int64_t job = 0;
  std::uint64_t heartbeat = 0;
  friend bool operator==(const JobLease&, const JobLease&) = default;
};

/// What a server may have to do.
struct OpenJobs {
  std::size_t queued = 0;
  std::vector<JobLease> running;  ///< By number.
};

enum class LeaseState {
  kHeld,
  kCancelled,  ///< Held, but the work is to be given up.
  kLost,       ///< Another server has taken the job over, or it is finished.
};

/// How a job ended.
struct JobOutcome {
  JobStatus status = JobStatus::kSucceeded;  ///< A finished one.
  std::string answer{};                      ///< Of one that succeeded: a document.
  std::string problem{};                     ///< Of one that failed.
};

class JobStore {
 public:
  explicit JobStore(std::shared_ptr<Database> database);
  ~JobStore();
  JobStore(JobStore&&) noexcept;

  /// Nothing when the limits are reached. Servers that insert at once may exceed them by one each.
  [[nodiscard]] Result<std::optional<JobRecord>> insert(const NewJob& job, const JobLimits& limits);
  [[nodiscard]] Result<JobRecord> find(std::string_view id);               ///< kNotFound.
  [[nodiscard]] Result<std::vector<JobRecord>> list(const JobPage& page);  ///< By number.
  /// Of a job that succeeded: kConflict for another one, kNotFound for an unknown one.
  [[nodiscard]] Result<std::string> answer(std::string_view id);

  /// A queued job ends at once; a running one when its holder sees it. kConflict when it is
  /// finished, kNotFound.
  [[nodiscard]] Result<JobRecord> cancel(std::string_view id, std::string_view now);
  [[nodiscard]] Result<void> remove_finished_before(std::string_view time);

  [[nodiscard]] Result<OpenJobs> open_jobs();
  /// The oldest job that is queued or has one of the leases `expired`, now held by `holder`.
  /// Jobs of one map run in their order: one before which another of the map is not finished has to
  /// wait. Nothing when there is none. Never waits for another server that claims.
  [[nodiscard]] Result<std::optional<JobRecord>> claim(std::string_view holder,
                                                       std::span<const JobLease> expired,
                                                       std::string_view now);
  [[nodiscard]] Result<JobInput> input(std::int64_t job);
  /// Adds to the input of a job that waited for earlier jobs which revision of the map these left.
  /// \param new_id  Of the map, when an earlier job has made it; else 0.
  [[nodiscard]] Result<void> keep_map(std::int64_t job, std::uint64_t revision,
                                      std::int64_t new_id);
  /// By kind and status, of all jobs that there are.
  [[nodiscard]] Result<std::vector<JobCount>> counts();
  /// Keeps the job and writes how far it is.
  [[nodiscard]] Result<LeaseState> renew(std::int64_t job, std::string_view holder,
                                         std::string_view stage, double progress);
  /// Ends the job and drops its input. False, and nothing changes, when `holder` has lost it.
  [[nodiscard]] Result<bool> finish(std::int64_t job, std::string_view holder,
                                    const JobOutcome& outcome, std::string_view now);
  /// Puts the job back into the queue, unless `holder` has lost it. \param counts  As an attempt.
  [[nodiscard]] Result<void> release(std::int64_t job, std::string_view holder, bool counts);

 private:
  std::shared_ptr<Database> database_;
};

}  // namespace cornerfix::storage

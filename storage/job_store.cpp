#include "storage/job_store.hpp"

#include <array>
#include <string>
#include <utility>

#include "storage/database.hpp"
#include "storage/job_tables.hpp"

namespace cornerfix::storage {
namespace {

constexpr std::array<std::string_view, 5> kJobStatusNames = {"queued", "running", "succeeded",
                                                             "failed", "cancelled"};

Error unknown_job(std::string_view id) {
  return Error{ErrorCode::kNotFound, "there is no job " + std::string(id), "job"};
}

bool is_held_by(const std::optional<JobRecord>& job, std::string_view holder) {
  return job && job->status == JobStatus::kRunning && job->holder == holder;
}

/// The inputs that keep the revision of the map and its id.
constexpr const char* kMapRevision = "map_revision";
constexpr const char* kMapId = "map_id";

void insert_number(JobTables& jobs, std::int64_t job, const char* name, std::uint64_t number) {
  const std::string text = std::to_string(number);
  jobs.insert_input(job, name,
                    BlobView(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

void insert_map_id(JobTables& jobs, std::int64_t job, std::int64_t id) {
  if (id > 0) insert_number(jobs, job, kMapId, static_cast<std::uint64_t>(id));
}

std::optional<std::uint64_t> number_in(const JobInput& input, const char* name) {
  const auto kept = input.find(name);
  if (kept == input.end()) return std::nullopt;
  return std::stoull(std::string(kept->second.begin(), kept->second.end()));
}

/// Ends a job; what it worked on is of no use any more.
void end_job(JobTables& jobs, JobRecord& job, JobStatus status, std::string_view now) {
  job.status = status;
  job.finished = now;
  job.holder.clear();
  if (status == JobStatus::kSucceeded) job.progress = 1.0;
  jobs.update(job);
  jobs.remove_input(job.number);
}

}  // namespace

std::string_view to_string(JobStatus status) {
  return kJobStatusNames.at(static_cast<std::size_t>(status));
}

JobStatus job_status_from(std::string_view text) {
  for (const JobStatus status : kJobStatuses) {
    if (to_string(status) == text) return status;
  }
  throw StorageError({ErrorCode::kCorruptData,
                      "the status of a job is '" + std::string(text) +
                          "', expected queued, running, "
                          "succeeded, failed or cancelled",
                      "job"});
}

std::optional<std::uint64_t> map_revision(const JobInput& input) {
  return number_in(input, kMapRevision);
}

std::int64_t map_id(const JobInput& input) {
  return static_cast<std::int64_t>(number_in(input, kMapId).value_or(0));
}

JobStore::JobStore(std::shared_ptr<Database> database) : database_(std::move(database)) {}
JobStore::~JobStore() = default;
JobStore::JobStore(JobStore&&) noexcept = default;

Result<std::optional<JobRecord>> JobStore::insert(const NewJob& job, const JobLimits& limits) {
  return guarded([&]() -> Result<std::optional<JobRecord>> {
    std::uint64_t bytes = 0;
    for (const auto& [name, content] : job.input) bytes += content.size();
    const auto transaction = database_->begin(Access::kWrite);
    JobTables& jobs = database_->jobs();
    const JobLoad load = jobs.load();
    if (load.jobs >= limits.jobs || load.input_bytes + bytes > limits.bytes)
      return std::optional<JobRecord>();
    const bool is_first = !jobs.has_unfinished(job.map);
    JobRecord record{.number = jobs.insert(job),
                     .id = job.id,
                     .kind = job.kind,
                     .map = job.map,
                     .created = job.created};
    if (job.known_map) insert_map_id(jobs, record.number, job.known_map->id);
    if (job.known_map && (is_first || job.known_map->is_required))
      insert_number(jobs, record.number, kMapRevision, job.known_map->revision);
    transaction->commit();
    return std::optional(std::move(record));
  });
}

Result<JobRecord> JobStore::find(std::string_view id) {
  return guarded([&]() -> Result<JobRecord> {
    std::optional<JobRecord> job = database_->jobs().find(id);
    if (!job) return unknown_job(id);
    return std::move(*job);
  });
}

Result<std::vector<JobRecord>> JobStore::list(const JobPage& page) {
  return guarded([&]() -> Result<std::vector<JobRecord>> { return database_->jobs().list(page); });
}

Result<std::string> JobStore::answer(std::string_view id) {
  return guarded([&]() -> Result<std::string> {
    const auto transaction = database_->begin(Access::kRead);
    JobTables& jobs = database_->jobs();
    const std::optional<JobRecord> job = jobs.find(id);
    if (!job) return unknown_job(id);
    if (job->status == JobStatus::kSucceeded) return jobs.answer(job->number);
    return Error{ErrorCode::kConflict,
                 "the job has no result: its status is " + std::string(to_string(job->status)),
                 "job"};
  });
}

Result<JobRecord> JobStore::cancel(std::string_view id, std::string_view now) {
  return guarded([&]() -> Result<JobRecord> {
    const auto transaction = database_->begin(Access::kWrite);
    JobTables& jobs = database_->jobs();
    std::optional<JobRecord> job = jobs.find(id);
    if (!job) return unknown_job(id);
    if (is_finished(job->status)) {
      return Error{ErrorCode::kConflict,
                   "the job is finished: its status is " + std::string(to_string(job->status)),
                   "job"};
    }
    if (job->status == JobStatus::kQueued) {
      end_job(jobs, *job, JobStatus::kCancelled, now);
    } else {
      job->is_cancelling = true;
      jobs.update(*job);
    }
    transaction->commit();
    return std::move(*job);
  });
}

Result<void> JobStore::remove_finished_before(std::string_view time) {
  return guarded([&]() -> Result<void> {
    const auto transaction = database_->begin(Access::kWrite);
    database_->jobs().remove_finished_before(time);
    transaction->commit();
    return {};
  });
}

Result<OpenJobs> JobStore::open_jobs() {
  return guarded([&]() -> Result<OpenJobs> { return database_->jobs().open_jobs(); });
}

Result<std::optional<JobRecord>> JobStore::claim(std::string_view holder,
                                                 std::span<const JobLease> expired,
                                                 std::string_view now) {
  return guarded([&]() -> Result<std::optional<JobRecord>> {
    const auto transaction = database_->begin(Access::kWrite);
    JobTables& jobs = database_->jobs();
    std::optional<JobRecord> job = jobs.find_claimable(expired);
    if (!job) return job;
    job->status = JobStatus::kRunning;
    job->holder = holder;
    job->started = now;
    job->stage.clear();
    job->progress = 0.0;
    ++job->heartbeat;
    ++job->attempts;
    jobs.update(*job);
    transaction->commit();
    return job;
  });
}

Result<JobInput> JobStore::input(std::int64_t job) {
  return guarded([&]() -> Result<JobInput> { return database_->jobs().input(job); });
}

Result<void> JobStore::keep_map(std::int64_t job, std::uint64_t revision, std::int64_t new_id) {
  return guarded([&]() -> Result<void> {
    const auto transaction = database_->begin(Access::kWrite);
    JobTables& jobs = database_->jobs();
    insert_number(jobs, job, kMapRevision, revision);
    insert_map_id(jobs, job, new_id);
    transaction->commit();
    return {};
  });
}

Result<std::vector<JobCount>> JobStore::counts() {
  return guarded([&]() -> Result<std::vector<JobCount>> { return database_->jobs().counts(); });
}

Result<LeaseState> JobStore::renew(std::int64_t number, std::string_view holder,
                                   std::string_view stage, double progress) {
  return guarded([&]() -> Result<LeaseState> {
    const auto transaction = database_->begin(Access::kWrite);
    JobTables& jobs = database_->jobs();
    std::optional<JobRecord> job = jobs.find(number);
    if (!is_held_by(job, holder)) return LeaseState::kLost;
    job->stage = stage;
    job->progress = progress;
    ++job->heartbeat;
    jobs.update(*job);
    transaction->commit();
    return job->is_cancelling ? LeaseState::kCancelled : LeaseState::kHeld;
  });
}

Result<bool> JobStore::finish(std::int64_t number, std::string_view holder,
                              const JobOutcome& outcome, std::string_view now) {
  return guarded([&]() -> Result<bool> {
    const auto transaction = database_->begin(Access::kWrite);
    JobTables& jobs = database_->jobs();
    std::optional<JobRecord> job = jobs.find(number);
    if (!is_held_by(job, holder)) return false;
    job->problem = outcome.problem;
    end_job(jobs, *job, outcome.status, now);
    if (!outcome.answer.empty()) jobs.put_answer(number, outcome.answer);
    transaction->commit();
    return true;
  });
}

Result<void> JobStore::release(std::int64_t number, std::string_view holder, bool counts) {
  return guarded([&]() -> Result<void> {
    const auto transaction = database_->begin(Access::kWrite);
    JobTables& jobs = database_->jobs();
    std::optional<JobRecord> job = jobs.find(number);
    if (!is_held_by(job, holder)) return {};
    job->status = JobStatus::kQueued;
    job->holder.clear();
    job->stage.clear();
    job->progress = 0.0;
    if (!counts) --job->attempts;
    jobs.update(*job);
    transaction->commit();
    return {};
  });
}

}  // namespace cornerfix::storage

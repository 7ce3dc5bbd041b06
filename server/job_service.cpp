#include "server/job_service.hpp"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "api/problem.hpp"
#include "server/event_log.hpp"
#include "server/random_id.hpp"

namespace cornerfix::server {

using storage::JobLease;
using storage::JobOutcome;
using storage::JobRecord;
using storage::JobStatus;
using storage::JobStore;
using storage::LeaseState;

namespace {

constexpr int kJobNiceness = 5;
constexpr std::chrono::minutes kRemovalInterval{10};

JobOutcome failed(const Error& error) {
  api::Problem problem = api::to_problem(error);
  if (problem.status == 500) problem.detail = "The server's log has the details, by the job's id.";
  return {.status = JobStatus::kFailed, .problem = api::render(problem)};
}

Error too_many_attempts() {
  return {ErrorCode::kUnavailable,
          "the job was begun " + std::to_string(JobService::kMaxAttempts) +
              " times and the server never finished it: its log may say why; submit the job again",
          ""};
}

}  // namespace

Error lost_map(std::string_view name) {
  return {ErrorCode::kConflict,
          "the map " + std::string(name) + " that the job was given for was deleted", ""};
}

JobService::JobService(std::shared_ptr<StoreAccess> stores, JobRunners runners,
                       JobServiceSettings settings)
    : stores_(std::move(stores)),
      runners_(std::move(runners)),
      settings_(std::move(settings)),
      holder_(random_id()),
      keeper_([this] { keep_lease(); }),
      worker_([this] { work(); }) {}

JobService::~JobService() {
  close();
  worker_.join();
  keeper_.join();
}

void JobService::close() {
  const std::lock_guard lock(mutex_);
  if (!closing_) closed_ = Clock::now();
  closing_ = true;
  changed_.notify_all();
}

Result<std::optional<JobRecord>> JobService::submit(
    std::string_view kind, std::string_view map,
    const std::map<std::string, storage::BlobView>& input,
    const std::optional<storage::JobMap>& known_map) {
  const storage::NewJob job{.id = random_id(),
                            .kind = std::string(kind),
                            .map = std::string(map),
                            .created = settings_.now(),
                            .input = input,
                            .known_map = known_map};
  auto inserted =
      stores_->with_jobs([&](JobStore& jobs) { return jobs.insert(job, settings_.limits); });
  if (!inserted || !inserted->has_value()) return inserted;
  const std::lock_guard lock(mutex_);
  has_news_ = true;
  changed_.notify_all();
  return inserted;
}

Result<JobRecord> JobService::find(std::string_view id) {
  return stores_->with_jobs([&](JobStore& jobs) { return jobs.find(id); });
}

Result<std::vector<JobRecord>> JobService::list(const storage::JobPage& page) {
  return stores_->with_jobs([&](JobStore& jobs) { return jobs.list(page); });
}

Result<std::string> JobService::answer(std::string_view id) {
  return stores_->with_jobs([&](JobStore& jobs) { return jobs.answer(id); });
}

Result<JobRecord> JobService::cancel(std::string_view id) {
  auto job = stores_->with_jobs([&](JobStore& jobs) { return jobs.cancel(id, settings_.now()); });
  const std::lock_guard lock(mutex_);
  must_renew_ = true;
  changed_.notify_all();
  return job;
}

Result<std::vector<storage::JobCount>> JobService::counts() {
  return stores_->with_jobs([&](JobStore& jobs) { return jobs.counts(); });
}

Result<JobRecord> JobService::wait_for(std::string_view id, std::chrono::seconds wait) {
  {
    const std::lock_guard lock(mutex_);
    if (waiters_ >= kMaxWaiters) wait = std::chrono::seconds(0);
    ++waiters_;
  }
  auto job = wait_until(id, Clock::now() + wait);
  const std::lock_guard lock(mutex_);
  --waiters_;
  return job;
}

/// Another server may do the job: then each heartbeat is a look at it.
Result<JobRecord> JobService::wait_until(std::string_view id, Clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  for (;;) {
    const std::uint64_t ended = ended_;
    const bool is_closing = closing_;
    lock.unlock();
    auto job = find(id);
    lock.lock();
    const Clock::time_point now = Clock::now();
    if (!job || is_finished(job->status) || is_closing || now >= deadline) return job;
    changed_.wait_until(lock, std::min(deadline, now + settings_.heartbeat),
                        [&] { return closing_ || ended_ != ended; });
  }
}

void JobService::work() {
  setpriority(PRIO_PROCESS, 0, kJobNiceness);  // On Linux: of this thread and those that it starts.
  std::unique_lock lock(mutex_);
  while (!closing_) {
    has_news_ = false;
    lock.unlock();
    const auto job = claim();
    if (job) run(*job);
    lock.lock();
    if (job && job->attempts <= 1) continue;
    // One that failed before is not tried again at once.
    changed_.wait_for(lock, settings_.heartbeat, [&] { return closing_ || has_news_; });
  }
  worker_ended_ = true;
  changed_.notify_all();
}

std::optional<JobRecord> JobService::claim() {
  remove_expired();
  const auto open = stores_->with_jobs([&](JobStore& jobs) { return jobs.open_jobs(); });
  if (!open) return std::nullopt;  // The next look may find the database again.
  const std::vector<JobLease> expired = expired_leases(open->running);
  if (open->queued == 0 && expired.empty()) return std::nullopt;
  auto claimed = stores_->with_jobs(
      [&](JobStore& jobs) { return jobs.claim(holder_, expired, settings_.now()); });
  return claimed ? std::move(*claimed) : std::nullopt;
}

void JobService::remove_expired() {
  const Clock::time_point now = Clock::now();
  if (!settings_.expired_before || now < next_removal_) return;
  const auto removed = stores_->with_jobs(
      [&](JobStore& jobs) { return jobs.remove_finished_before(settings_.expired_before()); });
  if (removed) next_removal_ = now + kRemovalInterval;
}

/// By this server's own clock, since it first saw the heartbeats as they are.
std::vector<JobLease> JobService::expired_leases(const std::vector<JobLease>& running) {
  const Clock::time_point now = Clock::now();
  std::map<std::int64_t, Sighting> seen;
  std::vector<JobLease> expired;
  for (const JobLease& lease : running) {
    const auto before = sightings_.find(lease.job);
    const bool stands_still =
        before != sightings_.end() && before->second.heartbeat == lease.heartbeat;
    const Sighting sighting{lease.heartbeat, stands_still ? before->second.since : now};
    seen.emplace(lease.job, sighting);
    if (now - sighting.since >= settings_.lease) expired.push_back(lease);
  }
  sightings_ = std::move(seen);
  return expired;
}

void JobService::run(const JobRecord& job) {
  // Its last server died before it saw that.
  if (job.is_cancelling) return finish(job, {.status = JobStatus::kCancelled});
  {
    const std::lock_guard lock(mutex_);
    current_ = Current{.number = job.number};
  }
  const auto answer = answer_of(job);
  end(job, answer);
  const std::lock_guard lock(mutex_);
  ++ended_;
  current_.reset();
  changed_.notify_all();
}

Result<std::string> JobService::answer_of(const JobRecord& job) {
  const auto runner = runners_.find(job.kind);
  if (runner == runners_.end()) {
    return Error{ErrorCode::kInvalidArgument,
                 "this server does not know jobs of the kind " + job.kind, ""};
  }
  if (job.attempts > kMaxAttempts) return too_many_attempts();
  auto input = stores_->with_jobs([&](JobStore& jobs) { return jobs.input(job.number); });
  if (!input) return input.error();
  const auto known = known_map(job, *input);
  if (!known) return known.error();
  try {
    return runner->second({.map = job.map,
                           .known_map = *known,
                           .input = std::move(*input),
                           .progress = [this](std::string_view stage, double share) {
                             return note_progress(stage, share);
                           }});
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kInternal, exception.what(), ""};
  }
}

Result<storage::KnownMap> JobService::known_map(const JobRecord& job,
                                                const storage::JobInput& input) {
  const std::int64_t id = storage::map_id(input);
  const auto found =
      stores_->with_maps([&](storage::MapStore& maps) { return maps.find(job.map); });
  if (!found && found.error().code != ErrorCode::kNotFound) return found.error();
  const storage::MapInfo map = found ? *found : storage::MapInfo{};
  if (id != 0 && map.id != id) return lost_map(job.map);
  if (const auto revision = storage::map_revision(input))
    return storage::KnownMap{.revision = *revision, .id = id};
  const auto kept = stores_->with_jobs([&](JobStore& jobs) {
    return jobs.keep_map(job.number, map.revision, id == 0 ? map.id : 0);
  });
  if (!kept) return kept.error();
  return storage::KnownMap{.revision = map.revision, .id = map.id};
}

bool JobService::note_progress(std::string_view stage, double share) {
  const std::lock_guard lock(mutex_);
  current_->stage = stage;
  current_->progress = share;
  return !closing_ && current_->lease == LeaseState::kHeld;
}

void JobService::end(const JobRecord& job, const Result<std::string>& answer) {
  LeaseState lease = LeaseState::kHeld;
  bool was_closing = false;
  {
    const std::lock_guard lock(mutex_);
    lease = current_->lease;
    was_closing = closing_;
  }
  if (lease == LeaseState::kLost) return;
  if (answer) return finish(job, {.status = JobStatus::kSucceeded, .answer = *answer});
  if (lease == LeaseState::kCancelled) return finish(job, {.status = JobStatus::kCancelled});
  const bool may_work_later =
      answer.error().code == ErrorCode::kUnavailable && job.attempts < kMaxAttempts;
  if (was_closing || may_work_later) {
    (void)stores_->with_jobs([&](JobStore& jobs) {
      return jobs.release(job.number, holder_, !was_closing);
    });  // Where this fails, the lease runs out.
    return;
  }
  if (api::http_status(answer.error().code) == 500)
    spdlog::error("job {} {}", job.id, answer.error().message);
  finish(job, failed(answer.error()));
}

/// Where this fails, the lease runs out and the job is begun anew.
void JobService::finish(const JobRecord& job, const JobOutcome& outcome) {
  Current last;  // A short job may have ended before its first heartbeat.
  {
    const std::lock_guard lock(mutex_);
    if (current_) last = *current_;
  }
  const auto finished = stores_->with_jobs([&](JobStore& jobs) -> Result<bool> {
    const auto lease = jobs.renew(job.number, holder_, last.stage, last.progress);
    if (!lease) return lease.error();
    return jobs.finish(job.number, holder_, outcome, settings_.now());
  });
  if (!finished || !*finished) return;
  if (settings_.on_end) {
    const std::chrono::duration<double> seconds = Clock::now() - last.began;
    settings_.on_end(job.kind, outcome.status, seconds.count());
  }
  log_event("job", {{"job", job.id},
                    {"kind", job.kind},
                    {"map", job.map},
                    {"status", to_string(outcome.status)}});
}

bool JobService::put_back(std::int64_t job) {
  return stores_->with_job_leases([&](JobStore& jobs) { return jobs.release(job, holder_, false); })
      .ok();
}

void JobService::keep_lease() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait_for(lock, settings_.heartbeat, [&] { return worker_ended_ || must_renew_; });
    must_renew_ = false;
    if (worker_ended_) return;  // Before, it may have claimed a job that is not in work yet.
    if (!current_) continue;
    const Current current = *current_;
    const bool is_late = closing_ && Clock::now() - closed_ >= settings_.patience;
    lock.unlock();
    if (is_late && put_back(current.number)) return;
    const auto lease = stores_->with_job_leases([&](JobStore& jobs) {
      return jobs.renew(current.number, holder_, current.stage, current.progress);
    });
    lock.lock();
    if (lease && current_ && current_->number == current.number) current_->lease = *lease;
  }
}

}  // namespace cornerfix::server

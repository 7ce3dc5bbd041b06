#include "server/report_service.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <utility>

namespace cornerfix::server {
namespace {

constexpr std::size_t kMaxUnfinished = 16;
constexpr std::size_t kMaxKept = 32;
constexpr std::size_t kMaxWaiting = 4;  // each holds a thread that robots might need
constexpr int kNiceness = 5;

SimulatedRobot robot_with(const std::optional<api::Lidar>& lidar) {
  SimulatedRobot robot;
  if (!lidar || !lidar->beams) return robot;
  robot.lidar.angle_min = lidar->angle_min;
  robot.lidar.angle_increment = lidar->angle_increment;
  robot.lidar.range_min = lidar->range_min;
  // No real lidar is without limit; a simulated one keeps the limit of SimulatedRobot then.
  if (std::isfinite(lidar->range_max)) robot.lidar.range_max = lidar->range_max;
  robot.beams = *lidar->beams;
  robot.T_base_link_laser = lidar->T_base_link_laser;
  return robot;
}

Error map_has_changed() { return {ErrorCode::kUnavailable, "the map has changed; ask again", ""}; }

}  // namespace

/// Under the service's mutex, but for `info`, which never changes.
struct ReportService::Job {
  explicit Job(storage::MapInfo the_info) : info(std::move(the_info)) {}

  const storage::MapInfo info;
  ReportView view;
  std::optional<Error> error;
  bool is_outdated = false;  ///< The map has changed or is gone: nobody will ask for it.

  [[nodiscard]] bool is_finished() const { return view.report != nullptr || error.has_value(); }
};

ReportService::ReportService(std::shared_ptr<MapLibrary> maps, Assess assess)
    : maps_(std::move(maps)), assess_(std::move(assess)), worker_([this] { work(); }) {}

ReportService::~ReportService() {
  close();
  worker_.join();
}

void ReportService::close() {
  const std::lock_guard lock(mutex_);
  closing_ = true;
  changed_.notify_all();
}

Result<ReportView> ReportService::get(const storage::MapInfo& info, std::chrono::seconds wait,
                                      ReportWaiter waiter) {
  std::unique_lock lock(mutex_);
  const auto job = find_or_begin(info);
  if (!job) return Error{ErrorCode::kUnavailable, "too many reports wait to be made", ""};
  const std::size_t places = waiter == ReportWaiter::kRequest ? 1 : 0;
  if (places == 0 || waiting_ < kMaxWaiting) {
    waiting_ += places;
    changed_.wait_for(lock, wait,
                      [&] { return closing_ || job->is_outdated || job->is_finished(); });
    waiting_ -= places;
  }
  if (job->is_outdated) return map_has_changed();
  if (job->error) {
    jobs_.remove(job);  // The next caller has it tried again.
    return *job->error;
  }
  return job->view;
}

void ReportService::forget(std::int64_t map_id) {
  const std::lock_guard lock(mutex_);
  const auto found = std::ranges::find(jobs_, map_id, [](const auto& job) { return job->info.id; });
  if (found == jobs_.end()) return;
  (*found)->is_outdated = true;
  jobs_.erase(found);
  changed_.notify_all();
}

/// With the mutex held. Null when there is no room.
std::shared_ptr<ReportService::Job> ReportService::find_or_begin(const storage::MapInfo& info) {
  const auto is_of_map = [&](const auto& job) { return job->info.id == info.id; };
  const auto found = std::ranges::find_if(jobs_, is_of_map);
  if (found != jobs_.end()) {
    if ((*found)->info.revision >= info.revision) return *found;  // `info` may be a little old.
    (*found)->is_outdated = true;
    jobs_.erase(found);
  }
  const auto unfinished =
      std::ranges::count_if(jobs_, [](const auto& job) { return !job->is_finished(); });
  if (static_cast<std::size_t>(unfinished) >= kMaxUnfinished) return nullptr;
  if (jobs_.size() >= kMaxKept)
    jobs_.erase(std::ranges::find_if(jobs_, [](const auto& job) { return job->is_finished(); }));
  jobs_.push_back(std::make_shared<Job>(info));
  jobs_.back()->view.revision = info.revision;
  changed_.notify_all();
  return jobs_.back();
}

void ReportService::work() {
  setpriority(PRIO_PROCESS, 0, kNiceness);  // On Linux: of this thread.
  std::unique_lock lock(mutex_);
  for (;;) {
    std::shared_ptr<Job> next;
    changed_.wait(lock, [&] {
      const auto found =
          std::ranges::find_if(jobs_, [](const auto& job) { return !job->is_finished(); });
      if (found != jobs_.end()) next = *found;
      return closing_ || next != nullptr;
    });
    if (closing_) return;
    lock.unlock();
    try {
      make(*next);
    } catch (const std::exception& exception) {
      fail(*next, {ErrorCode::kInternal, exception.what(), ""});
    }
    lock.lock();
    changed_.notify_all();
  }
}

void ReportService::fail(Job& job, Error error) {
  const std::lock_guard lock(mutex_);
  job.error = std::move(error);
}

void ReportService::make(Job& job) {
  const auto lidar = maps_->lidar(job.info);
  if (!lidar) return fail(job, lidar.error());
  const auto map = maps_->load(job.info);
  if (!map) return fail(job, map.error());
  LocalizabilityParams params;
  params.robot = robot_with(*lidar);
  auto report = assess_(*map, params, [&](double share) {
    const std::lock_guard lock(mutex_);
    job.view.progress = share;
    return !closing_ && !job.is_outdated;
  });
  if (!report) return fail(job, map_has_changed());
  const std::lock_guard lock(mutex_);
  job.view = {.report = std::make_shared<const LocalizabilityReport>(std::move(*report)),
              .revision = (*map)->revision(),
              .progress = 1.0};
}

}  // namespace cornerfix::server

/// \file  The use case on localizability reports: made one after the other beside the requests, and
/// kept until their maps change.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include <cornerfix/localizability.hpp>

#include "server/map_library.hpp"

namespace cornerfix::server {

/// How far a map's report is.
struct ReportView {
  std::shared_ptr<const LocalizabilityReport> report;  ///< Null while it is being made.
  std::uint64_t revision = 0;                          ///< Of the map that it is of.
  double progress = 0.0;                               ///< In [0, 1].
};

/// Who waits for a report.
enum class ReportWaiter {
  kRequest,  ///< Its thread may be needed by a robot: only a few may wait.
  kJob,      ///< Has a thread of its own.
};

/// One thread of low priority makes the reports, so that robots' answers do not wait for them. Any
/// threads may call.
class ReportService {
 public:
  using Assess = std::function<std::optional<LocalizabilityReport>(
      const LocalizationMapPtr&, const LocalizabilityParams&, const AssessmentProgress&)>;

  explicit ReportService(std::shared_ptr<MapLibrary> maps, Assess assess = assess_localizability);
  ~ReportService();
  ReportService(const ReportService&) = delete;
  ReportService& operator=(const ReportService&) = delete;

  /// The report of this revision; begun when it is not there, and waited for so long. Robots are
  /// simulated with the map's lidar if it names one with its beams, else with that of
  /// SimulatedRobot. kUnavailable when too many reports wait, kInternal when making it threw.
  [[nodiscard]] Result<ReportView> get(const storage::MapInfo& info, std::chrono::seconds wait,
                                       ReportWaiter waiter = ReportWaiter::kRequest);

  /// The map was deleted: gives its report up, and those who wait for it get kUnavailable.
  void forget(std::int64_t map_id);

  /// Nobody waits any longer, and what is in work is given up.
  void close();

 private:
  struct Job;

  [[nodiscard]] std::shared_ptr<Job> find_or_begin(const storage::MapInfo& info);
  void work();
  void make(Job& job);
  void fail(Job& job, Error error);

  std::shared_ptr<MapLibrary> maps_;
  const Assess assess_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<std::shared_ptr<Job>> jobs_;  ///< Newest last.
  std::size_t waiting_ = 0;               ///< Requests in get().
  bool closing_ = false;
  std::thread worker_;
};

}  // namespace cornerfix::server

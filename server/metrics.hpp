/// \file  What the service counts, as Prometheus reads it.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/localization_service.hpp"
#include "server/map_library.hpp"
#include "server/map_ranking.hpp"
#include "server/process_usage.hpp"
#include "storage/job_store.hpp"

namespace cornerfix::server {

/// What the server is doing now.
struct ServerLoad {
  std::size_t connections = 0;
  std::size_t requests_in_work = 0;  ///< Being answered or waiting for a thread.
  std::size_t workers = 0;           ///< Threads that answer.
  std::size_t busy_workers = 0;
  std::size_t event_clients = 0;
};

/// What is looked up whenever metrics are asked for.
struct MetricsSnapshot {
  SessionCounts sessions{};
  MapCacheUse maps{};
  MapRankingUse ranking{};
  ServerLoad load{};
  ProcessUsage process{};
  DatabaseUsage database{};
  std::vector<storage::JobCount> jobs{};
};

/// Any threads may call.
class Metrics {
 public:
  Metrics();
  ~Metrics();

  /// `route` is a pattern ("/v1/maps/{map}"), never a path, so that the number of series is small.
  void count_request(std::string_view method, std::string_view route, int status, double seconds);
  void count_batch(const BatchEvents& events);
  /// A request that was answered 503 unread: `reason` is the code of its problem.
  void count_shed(std::string_view reason);
  /// A request that was answered 429: `reason` is the code of its problem.
  void count_limited(std::string_view reason);
  /// A job that ended here after so much work.
  void count_job(std::string_view kind, storage::JobStatus status, double seconds);
  /// An address that was locked out after wrong tokens.
  void count_lockout();

  /// Prometheus text format 0.0.4.
  [[nodiscard]] std::string render(const MetricsSnapshot& now);

 private:
  void set_jobs(const std::vector<storage::JobCount>& counts);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cornerfix::server

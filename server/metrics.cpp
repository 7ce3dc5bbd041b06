#include "server/metrics.hpp"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "server/job_runners.hpp"

namespace cornerfix::server {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;
using prometheus::Histogram;

/// From an answer without work to one that a robot would call too late.
const Histogram::BucketBoundaries kSecondsBuckets = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025,
                                                     0.05,   0.1,   0.25,   0.5,   1.0,  2.5,
                                                     5.0,    10.0,  30.0,   60.0,  600.0};
/// From the import of a small occupancy map to the mapping of a day's run.
const Histogram::BucketBoundaries kJobBuckets = {0.1,  0.5,  1.0,   2.5,   5.0,   10.0,
                                                 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0};
const Histogram::BucketBoundaries kLocalizationBuckets = {0.2,  0.5,  1.0,  2.0,   5.0,   10.0,
                                                          20.0, 30.0, 60.0, 120.0, 300.0, 600.0};

std::string text_of(Reason reason) {
  return reason == Reason::kNone ? "none" : std::string(to_string(reason));
}

}  // namespace

struct Metrics::Impl {
  prometheus::Registry registry;
  std::mutex totals_mutex;
  prometheus::Family<prometheus::Counter>& requests =
      BuildCounter()
          .Name("cornerfix_http_requests_total")
          .Help("Requests by route, method and status.")
          .Register(registry);
  prometheus::Family<Histogram>& durations = BuildHistogram()
                                                 .Name("cornerfix_http_request_duration_seconds")
                                                 .Help("Time to an answer, by route.")
                                                 .Register(registry);
  prometheus::Counter& scans = counter("cornerfix_scans_total", "Scans taken from robots.");
  prometheus::Counter& fixes = counter("cornerfix_fixes_total", "Times a robot became localized.");
  prometheus::Counter& lost = counter("cornerfix_lost_total", "Times a robot became lost.");
  prometheus::Family<prometheus::Counter>& withdrawals =
      BuildCounter()
          .Name("cornerfix_withdrawals_total")
          .Help("Localized poses that were withdrawn, by cause.")
          .Register(registry);
  prometheus::Counter& odometry_ignored =
      counter("cornerfix_odometry_ignored_scans_total",
              "Scans whose odometry was ignored because it contradicts scan matching.");
  prometheus::Family<prometheus::Gauge>& sessions = BuildGauge()
                                                        .Name("cornerfix_sessions")
                                                        .Help("Sessions in memory by status.")
                                                        .Register(registry);
  prometheus::Family<prometheus::Counter>& answers =
      BuildCounter()
          .Name("cornerfix_answers_total")
          .Help("Answers to batches by status and reason.")
          .Register(registry);
  prometheus::Family<prometheus::Counter>& stages =
      BuildCounter()
          .Name("cornerfix_stage_seconds_total")
          .Help("Time spent on scans by stage of localization.")
          .Register(registry);
  prometheus::Counter& odometry = stages.Add({{"stage", "odometry"}});
  prometheus::Counter& extract = stages.Add({{"stage", "extract"}});
  prometheus::Counter& match = stages.Add({{"stage", "match"}});
  prometheus::Counter& verify = stages.Add({{"stage", "verify"}});
  prometheus::Counter& track = stages.Add({{"stage", "track"}});
  Histogram& localization_times =
      BuildHistogram()
          .Name("cornerfix_time_to_localization_seconds")
          .Help("From the first scan of a search to the scan that localized, by their stamps.")
          .Register(registry)
          .Add({}, kLocalizationBuckets);
  prometheus::Family<prometheus::Counter>& sheds =
      BuildCounter()
          .Name("cornerfix_requests_shed_total")
          .Help("Requests answered 503 unread, by reason.")
          .Register(registry);
  prometheus::Family<prometheus::Counter>& limited = BuildCounter()
                                                         .Name("cornerfix_requests_limited_total")
                                                         .Help("Requests answered 429, by reason.")
                                                         .Register(registry);
  prometheus::Family<prometheus::Gauge>& jobs =
      BuildGauge().Name("cornerfix_jobs").Help("Jobs in the database.").Register(registry);
  prometheus::Family<Histogram>& job_durations =
      BuildHistogram()
          .Name("cornerfix_job_duration_seconds")
          .Help("Work on jobs that ended on this server.")
          .Register(registry);
  prometheus::Counter& lockouts =
      counter("cornerfix_lockouts_total", "Addresses that were locked out after wrong tokens.");
  prometheus::Gauge& build = BuildGauge()
                                 .Name("cornerfix_build_info")
                                 .Help("1, with the version that is running.")
                                 .Register(registry)
                                 .Add({{"version", CORNERFIX_VERSION}});
  prometheus::Gauge& connections = gauge("cornerfix_connections", "Open connections.");
  prometheus::Gauge& in_work =
      gauge("cornerfix_requests_in_work", "Requests being answered or waiting for a thread.");
  prometheus::Gauge& workers = gauge("cornerfix_workers", "Threads that answer requests.");
  prometheus::Gauge& busy_workers = gauge("cornerfix_workers_busy", "Of these, those that do.");
  prometheus::Gauge& event_clients = gauge("cornerfix_event_clients", "Watchers of sessions.");
  prometheus::Counter& map_loads =
      counter("cornerfix_map_loads_total", "Maps made ready since the start.");
  prometheus::Gauge& database_bytes = gauge("cornerfix_database_bytes", "The database's file.");
  prometheus::Gauge& wal_bytes =
      gauge("cornerfix_database_wal_bytes", "The database's write-ahead log.");
  prometheus::Gauge& disk_free =
      gauge("cornerfix_disk_free_bytes", "Left on the disk of the database.");
  prometheus::Counter& cpu =
      counter("process_cpu_seconds_total", "Processor time of user and system.");
  prometheus::Gauge& resident = gauge("process_resident_memory_bytes", "Memory that is in use.");
  prometheus::Gauge& descriptors = gauge("process_open_fds", "Open file descriptors.");
  prometheus::Gauge& max_descriptors =
      gauge("process_max_fds", "Most file descriptors that may be open.");
  prometheus::Gauge& cached_maps = gauge("cornerfix_map_cache_maps", "Maps held ready.");
  prometheus::Gauge& cached_bytes =
      gauge("cornerfix_map_cache_bytes", "Memory of maps held ready.");
  prometheus::Gauge& ranked_maps =
      gauge("cornerfix_ranked_maps", "Maps that a robot in any map may be in.");
  prometheus::Gauge& ranking_sketches =
      gauge("cornerfix_map_ranking_sketches", "Of these, those with a current sketch.");
  prometheus::Gauge& ranking_bytes =
      gauge("cornerfix_map_ranking_bytes", "Memory of the sketches and their index.");

  prometheus::Counter& counter(const char* name, const char* help) {
    return BuildCounter().Name(name).Help(help).Register(registry).Add({});
  }
  prometheus::Gauge& gauge(const char* name, const char* help) {
    return BuildGauge().Name(name).Help(help).Register(registry).Add({});
  }
};

Metrics::Metrics() : impl_(std::make_unique<Impl>()) {
  impl_->build.Set(1.0);
  for (const Withdrawal cause :
       {Withdrawal::kScansLost, Withdrawal::kContradicted, Withdrawal::kRival})
    impl_->withdrawals.Add({{"cause", std::string(to_string(cause))}});
}
Metrics::~Metrics() = default;

void Metrics::count_request(std::string_view method, std::string_view route, int status,
                            double seconds) {
  const std::string route_label(route);
  impl_->requests
      .Add({{"method", std::string(method)},
            {"route", route_label},
            {"status", std::to_string(status)}})
      .Increment();
  impl_->durations.Add({{"route", route_label}}, kSecondsBuckets).Observe(seconds);
}

void Metrics::count_batch(const BatchEvents& events) {
  impl_->scans.Increment(static_cast<double>(events.scans));
  impl_->fixes.Increment(static_cast<double>(events.fixes));
  impl_->lost.Increment(static_cast<double>(events.lost));
  for (const auto& [cause, count] : events.withdrawals) {
    impl_->withdrawals.Add({{"cause", std::string(to_string(cause))}})
        .Increment(static_cast<double>(count));
  }
  impl_->odometry_ignored.Increment(static_cast<double>(events.odometry_ignored));
  impl_->answers
      .Add({{"status", std::string(to_string(events.status))}, {"reason", text_of(events.reason)}})
      .Increment();
  const StepTimes& times = events.times;
  impl_->odometry.Increment(times.odometry_ms / 1e3);
  impl_->extract.Increment(times.extract_ms / 1e3);
  impl_->match.Increment(times.match_ms / 1e3);
  impl_->verify.Increment(times.verify_ms / 1e3);
  impl_->track.Increment(times.track_ms / 1e3);
  for (const double seconds : events.times_to_localization_s)
    impl_->localization_times.Observe(seconds);
}

void Metrics::count_shed(std::string_view reason) {
  impl_->sheds.Add({{"reason", std::string(reason)}}).Increment();
}

void Metrics::count_limited(std::string_view reason) {
  impl_->limited.Add({{"reason", std::string(reason)}}).Increment();
}

void Metrics::count_job(std::string_view kind, storage::JobStatus status, double seconds) {
  impl_->job_durations
      .Add({{"kind", std::string(kind)}, {"status", std::string(to_string(status))}}, kJobBuckets)
      .Observe(seconds);
}

void Metrics::count_lockout() { impl_->lockouts.Increment(); }

namespace {

void set(prometheus::Gauge& gauge, std::size_t value) { gauge.Set(static_cast<double>(value)); }

/// To a total that is counted elsewhere.
void raise_to(prometheus::Counter& counter, double total) {
  counter.Increment(std::max(0.0, total - counter.Value()));
}

}  // namespace

void Metrics::set_jobs(const std::vector<storage::JobCount>& counts) {
  const auto gauge = [this](std::string_view kind, storage::JobStatus status) -> auto& {
    return impl_->jobs.Add(
        {{"kind", std::string(kind)}, {"status", std::string(to_string(status))}});
  };
  for (const char* kind : kJobKinds) {
    for (const auto status : storage::kJobStatuses) gauge(kind, status).Set(0.0);
  }
  for (const storage::JobCount& count : counts) set(gauge(count.kind, count.status), count.jobs);
}

std::string Metrics::render(const MetricsSnapshot& now) {
  set_jobs(now.jobs);
  for (const Status status :
       {Status::kCollecting, Status::kAmbiguous, Status::kLocalized, Status::kLost}) {
    set(impl_->sessions.Add({{"status", std::string(to_string(status))}}),
        now.sessions[static_cast<std::size_t>(status)]);
  }
  set(impl_->cached_maps, now.maps.maps);
  set(impl_->cached_bytes, now.maps.bytes);
  set(impl_->ranked_maps, now.ranking.maps);
  set(impl_->ranking_sketches, now.ranking.sketches);
  set(impl_->ranking_bytes, now.ranking.bytes);
  set(impl_->connections, now.load.connections);
  set(impl_->in_work, now.load.requests_in_work);
  set(impl_->workers, now.load.workers);
  set(impl_->busy_workers, now.load.busy_workers);
  set(impl_->event_clients, now.load.event_clients);
  set(impl_->database_bytes, now.database.file_bytes);
  set(impl_->wal_bytes, now.database.wal_bytes);
  set(impl_->disk_free, now.database.disk_free_bytes);
  set(impl_->resident, now.process.resident_bytes);
  set(impl_->descriptors, now.process.open_descriptors);
  set(impl_->max_descriptors, now.process.max_descriptors);
  {
    const std::lock_guard lock(impl_->totals_mutex);
    raise_to(impl_->cpu, now.process.cpu_s);
    raise_to(impl_->map_loads, static_cast<double>(now.maps.loads));
  }
  return prometheus::TextSerializer().Serialize(impl_->registry.Collect());
}

}  // namespace cornerfix::server

#include "server/metrics.hpp"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

namespace cornerfix::server {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;
using prometheus::Histogram;

/// From an answer without work to one that a robot would call too late.
const Histogram::BucketBoundaries kSecondsBuckets = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025,
                                                     0.05,   0.1,   0.25,   0.5,   1.0,  2.5};

}  // namespace

struct Metrics::Impl {
  prometheus::Registry registry;
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
  prometheus::Gauge& cached_maps = gauge("cornerfix_map_cache_maps", "Maps held ready.");
  prometheus::Gauge& cached_bytes =
      gauge("cornerfix_map_cache_bytes", "Memory of maps held ready.");

  prometheus::Counter& counter(const char* name, const char* help) {
    return BuildCounter().Name(name).Help(help).Register(registry).Add({});
  }
  prometheus::Gauge& gauge(const char* name, const char* help) {
    return BuildGauge().Name(name).Help(help).Register(registry).Add({});
  }
};

Metrics::Metrics() : impl_(std::make_unique<Impl>()) {
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
}

std::string Metrics::render(const SessionCounts& sessions, const MapCacheUse& maps) {
  for (const Status status :
       {Status::kCollecting, Status::kAmbiguous, Status::kLocalized, Status::kLost}) {
    impl_->sessions.Add({{"status", std::string(to_string(status))}})
        .Set(static_cast<double>(sessions[static_cast<std::size_t>(status)]));
  }
  impl_->cached_maps.Set(static_cast<double>(maps.maps));
  impl_->cached_bytes.Set(static_cast<double>(maps.bytes));
  return prometheus::TextSerializer().Serialize(impl_->registry.Collect());
}

}  // namespace cornerfix::server

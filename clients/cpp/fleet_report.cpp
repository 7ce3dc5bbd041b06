#include "clients/cpp/fleet_report.hpp"

#include <string>

#include "evaluation/metrics/percentile.hpp"

namespace cornerfix::client {

namespace {

nlohmann::ordered_json tally_json(const BatchTally& tally) {
  nlohmann::ordered_json json = {{"offered", tally.offered}, {"served", tally.served},
                                 {"late", tally.late},       {"shed", tally.shed},
                                 {"failed", tally.failed},   {"localized", tally.localized}};
  auto& latency = json["latency_ms"] = nlohmann::ordered_json::object();
  for (const ReportedPercentile& percentile : kReportedPercentiles)
    latency[percentile.name] = latency_ms(tally, percentile.share);
  for (const auto& [status, count] : tally.other_statuses)
    json["failures"][std::to_string(status)] = count;
  return json;
}

}  // namespace

double latency_ms(const BatchTally& tally, double share) {
  return tally.latencies_ms.empty() ? 0.0 : evaluation::percentile(tally.latencies_ms, share);
}

double cpu_ms_per_batch(const FleetReport& report) {
  const std::size_t served = report.tracking.served + report.searching.served;
  return served == 0 ? 0.0 : 1e3 * report.server_cpu_s / static_cast<double>(served);
}

nlohmann::ordered_json fleet_report_json(const FleetOptions& options, const FleetReport& report) {
  return {{"robots", options.robots},
          {"batches_per_s", options.batches_per_s},
          {"scans_per_batch", options.batch},
          {"searching_share", options.searching},
          {"seconds", options.seconds},
          {"ramp", tally_json(report.ramp)},
          {"tracking", tally_json(report.tracking)},
          {"searching", tally_json(report.searching)},
          {"server_cpu_ms_per_batch", cpu_ms_per_batch(report)}};
}

}  // namespace cornerfix::client

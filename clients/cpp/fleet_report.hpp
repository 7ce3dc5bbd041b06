/// \file  The figures of a fleet's load, for files and for people.
#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "clients/cpp/fleet_load.hpp"

namespace cornerfix::client {

/// A percentile of latencies that is reported.
struct ReportedPercentile {
  const char* name;
  double share;
};

inline constexpr std::array<ReportedPercentile, 4> kReportedPercentiles = {
    {{"p50", 0.5}, {"p95", 0.95}, {"p99", 0.99}, {"max", 1.0}}};

/// 0 when no batch was served.
[[nodiscard]] double latency_ms(const BatchTally& tally, double share);

/// Processor time of the server while all robots were on; 0 when no batch was served.
[[nodiscard]] double cpu_ms_per_batch(const FleetReport& report);

[[nodiscard]] nlohmann::ordered_json fleet_report_json(const FleetOptions& options,
                                                       const FleetReport& report);

}  // namespace cornerfix::client

#include "clients/cpp/fleet_report.hpp"

#include <gtest/gtest.h>

namespace cornerfix::client {
namespace {

TEST(FleetReportJson, CountsBatchesAndLatencies) {
  FleetReport report;
  report.tracking.offered = 4;
  report.tracking.served = 3;
  report.tracking.failed = 1;
  report.tracking.latencies_ms = {3.0, 1.0, 2.0};
  report.tracking.other_statuses[500] = 1;
  report.server_cpu_s = 0.012;
  const auto json = fleet_report_json({.server = {}, .map = {}, .robots = 7}, report);
  EXPECT_EQ(json["robots"], 7);
  EXPECT_EQ(json["tracking"]["served"], 3);
  EXPECT_EQ(json["tracking"]["latency_ms"]["p50"], 2.0);
  EXPECT_EQ(json["tracking"]["latency_ms"]["max"], 3.0);
  EXPECT_EQ(json["tracking"]["failures"]["500"], 1);
  EXPECT_DOUBLE_EQ(json["server_cpu_ms_per_batch"], 4.0);
}

TEST(FleetReportJson, HasZerosWhenNothingWasServed) {
  const FleetReport report;
  EXPECT_EQ(latency_ms(report.searching, 0.5), 0.0);
  EXPECT_EQ(cpu_ms_per_batch(report), 0.0);
}

}  // namespace
}  // namespace cornerfix::client

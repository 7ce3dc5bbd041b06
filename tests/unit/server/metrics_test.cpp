#include "server/metrics.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;

TEST(Metrics, CountsRequestsByRouteMethodAndStatus) {
  Metrics metrics;
  metrics.count_request("GET", "/v1/maps/{map}", 404, 0.002);
  metrics.count_request("GET", "/v1/maps/{map}", 404, 0.002);
  const std::string text = metrics.render({});
  EXPECT_THAT(text, HasSubstr("cornerfix_http_requests_total{method=\"GET\",route=\"/v1/maps/"
                              "{map}\",status=\"404\"} 2"));
  EXPECT_THAT(text, HasSubstr("cornerfix_http_request_duration_seconds_count{route=\"/v1/maps/"
                              "{map}\"} 2"));
}

TEST(Metrics, CountsWhatBatchesDid) {
  Metrics metrics;
  metrics.count_batch({.scans = 5, .fixes = 1, .lost = 0});
  metrics.count_batch({.scans = 5, .fixes = 0, .lost = 1});
  const std::string text = metrics.render({});
  EXPECT_THAT(text, HasSubstr("cornerfix_scans_total 10"));
  EXPECT_THAT(text, HasSubstr("cornerfix_fixes_total 1"));
  EXPECT_THAT(text, HasSubstr("cornerfix_lost_total 1"));
}

TEST(Metrics, TellsWhatIsInMemory) {
  const std::string text = Metrics().render({.sessions = {1, 2, 3, 4},
                                             .maps = {.maps = 5, .bytes = 6000, .loads = 7},
                                             .ranking = {.maps = 9, .sketches = 8, .bytes = 7000}});
  EXPECT_THAT(text, HasSubstr("cornerfix_sessions{status=\"collecting\"} 1"));
  EXPECT_THAT(text, HasSubstr("cornerfix_sessions{status=\"lost\"} 4"));
  EXPECT_THAT(text, HasSubstr("cornerfix_map_cache_maps 5"));
  EXPECT_THAT(text, HasSubstr("cornerfix_map_cache_bytes 6000"));
  EXPECT_THAT(text, HasSubstr("cornerfix_ranked_maps 9"));
  EXPECT_THAT(text, HasSubstr("cornerfix_map_ranking_sketches 8"));
  EXPECT_THAT(text, HasSubstr("cornerfix_map_ranking_bytes 7000"));
}

TEST(Metrics, CountsAnswersByStatusAndReason) {
  Metrics metrics;
  metrics.count_batch({.scans = 1,
                       .status = Status::kCollecting,
                       .reason = Reason::kNoMatch,
                       .times = {.odometry_ms = 500.0}});
  metrics.count_batch(
      {.scans = 1, .status = Status::kLocalized, .times_to_localization_s = {12.5}});
  const std::string text = metrics.render({});
  EXPECT_THAT(text, HasSubstr("{reason=\"no_match\",status=\"collecting\"} 1"));
  EXPECT_THAT(text, HasSubstr("{reason=\"none\",status=\"localized\"} 1"));
  EXPECT_THAT(text, HasSubstr("cornerfix_stage_seconds_total{stage=\"odometry\"} 0.5"));
  EXPECT_THAT(text, HasSubstr("cornerfix_time_to_localization_seconds_bucket{le=\"20\"} 1"));
  EXPECT_THAT(text, HasSubstr("cornerfix_time_to_localization_seconds_bucket{le=\"10\"} 0"));
}

TEST(Metrics, CountsJobsByKindAndStatusAndTheirSeconds) {
  Metrics metrics;
  metrics.count_job("import", storage::JobStatus::kSucceeded, 2.0);
  metrics.count_job("import", storage::JobStatus::kSucceeded, 3.0);
  const std::string text = metrics.render({.jobs = {{"import", storage::JobStatus::kQueued, 4}}});
  EXPECT_THAT(text, HasSubstr("cornerfix_jobs{kind=\"import\",status=\"queued\"} 4"));
  EXPECT_THAT(text, HasSubstr("cornerfix_jobs{kind=\"mapping\",status=\"running\"} 0"));
  EXPECT_THAT(text, HasSubstr("cornerfix_job_duration_seconds_sum{kind=\"import\",status="
                              "\"succeeded\"} 5"));
  EXPECT_THAT(metrics.render({}), HasSubstr("cornerfix_jobs{kind=\"import\",status=\"queued\"} 0"));
}

TEST(Metrics, TellsWhatTheServerUses) {
  Metrics metrics;
  metrics.count_shed("busy");
  const MetricsSnapshot now{
      .load = {.connections = 3, .requests_in_work = 2, .workers = 8, .busy_workers = 1},
      .process = {.cpu_s = 1.5, .resident_bytes = 1000, .open_descriptors = 9},
      .database = {.file_bytes = 10, .wal_bytes = 20, .disk_free_bytes = 30}};
  const std::string text = metrics.render(now);
  for (const char* line :
       {"cornerfix_requests_shed_total{reason=\"busy\"} 1", "cornerfix_connections 3",
        "cornerfix_requests_in_work 2", "cornerfix_workers_busy 1", "process_open_fds 9",
        "process_cpu_seconds_total 1.5", "cornerfix_database_wal_bytes 20",
        "cornerfix_disk_free_bytes 30", "cornerfix_build_info{version="}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
}

}  // namespace
}  // namespace cornerfix::server

#include "server/metrics.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;

TEST(Metrics, CountsRequestsByRouteMethodAndStatus) {
  Metrics metrics;
  metrics.count_request("GET", "/v1/maps/{map}", 404, 0.002);
  metrics.count_request("GET", "/v1/maps/{map}", 404, 0.002);
  const std::string text = metrics.render({}, {});
  EXPECT_THAT(text, HasSubstr("cornerfix_http_requests_total{method=\"GET\",route=\"/v1/maps/"
                              "{map}\",status=\"404\"} 2"));
  EXPECT_THAT(text, HasSubstr("cornerfix_http_request_duration_seconds_count{route=\"/v1/maps/"
                              "{map}\"} 2"));
}

TEST(Metrics, CountsWhatBatchesDid) {
  Metrics metrics;
  metrics.count_batch({.scans = 5, .fixes = 1, .lost = 0});
  metrics.count_batch({.scans = 5, .fixes = 0, .lost = 1});
  const std::string text = metrics.render({}, {});
  EXPECT_THAT(text, HasSubstr("cornerfix_scans_total 10"));
  EXPECT_THAT(text, HasSubstr("cornerfix_fixes_total 1"));
  EXPECT_THAT(text, HasSubstr("cornerfix_lost_total 1"));
}

TEST(Metrics, TellsWhatIsInMemory) {
  const std::string text = Metrics().render({1, 2, 3, 4}, MapCacheUse{.maps = 5, .bytes = 6000});
  EXPECT_THAT(text, HasSubstr("cornerfix_sessions{status=\"collecting\"} 1"));
  EXPECT_THAT(text, HasSubstr("cornerfix_sessions{status=\"lost\"} 4"));
  EXPECT_THAT(text, HasSubstr("cornerfix_map_cache_maps 5"));
  EXPECT_THAT(text, HasSubstr("cornerfix_map_cache_bytes 6000"));
}

}  // namespace
}  // namespace cornerfix::server

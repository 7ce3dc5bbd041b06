/// \file  The calls of the HTTP API: parse, ask a service, render. No logic of their own.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/event_hub.hpp"
#include "server/job_service.hpp"
#include "server/localization_service.hpp"
#include "server/map_library.hpp"
#include "server/map_ranking.hpp"
#include "server/metrics.hpp"
#include "server/report_service.hpp"
#include "server/router.hpp"
#include "server/server_config.hpp"

namespace cornerfix::server {

/// What the database may hold.
struct StoreQuotas {
  std::size_t maps = 20'000;
  std::uint64_t database_bytes = std::uint64_t{64} << 30U;
};

/// What routes call. Outlives every request.
struct Services {
  std::shared_ptr<StoreAccess> stores;
  std::shared_ptr<MapLibrary> maps;
  std::shared_ptr<MapRanking> ranking;
  std::shared_ptr<ReportService> reports;
  std::shared_ptr<JobService> jobs;
  std::shared_ptr<LocalizationService> localization;
  std::shared_ptr<EventHub> events;
  std::shared_ptr<Metrics> metrics;
  std::function<ServerLoad()> load;  ///< For the metrics.
  api::RequestLimits limits;
  std::uint64_t min_free_bytes = 0;  ///< On the database's disk, to be ready.
  StoreQuotas quotas{};
  std::shared_ptr<std::atomic<bool>> draining;  ///< Set when the server is going down.
};

/// The answer to what needs more room in the database than there may be; nothing when there is
/// some.
[[nodiscard]] std::optional<Response> refuse_growth(const Services& services,
                                                    const Request& request);
/// A 429 of a quota, counted.
[[nodiscard]] Response over_quota(const Services& services, std::string_view code,
                                  std::string detail);

using JobInputView = std::map<std::string, std::string_view>;

/// Takes a job about the map of the request's path: 202 with its location, or 429. When the client
/// waits and the job is finished by then, the answer of its work.
[[nodiscard]] Response accept_job(const Services& services, const Request& request,
                                  const char* kind, const JobInputView& input,
                                  const storage::JobMap& map);

void add_job_routes(Router& router, const Services& services);
void add_map_routes(Router& router, const Services& services);
void add_session_routes(Router& router, const Services& services);
void add_health_routes(Router& router, const Services& services);

/// All of them.
[[nodiscard]] Router make_router(const Services& services);

}  // namespace cornerfix::server

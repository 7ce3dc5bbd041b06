#include "api/openapi.hpp"
#include "server/responses.hpp"
#include "server/routes.hpp"

namespace cornerfix::server {
namespace {

Response ready(const Services& services, const Request& request) {
  if (*services.draining) {
    return problem_response(503, "draining", "The server is going down.");
  }
  if (const auto readable = services.stores->probe(services.min_free_bytes); !readable) {
    return error_response(request, Error{ErrorCode::kUnavailable, readable.error().message, ""});
  }
  return json_response(200, R"({"status":"ready"})");
}

/// None if the database fails: the other metrics are answered all the same.
std::vector<storage::JobCount> job_counts(const Services& services) {
  auto counts = services.jobs->counts();
  return counts ? std::move(*counts) : std::vector<storage::JobCount>();
}

Response metrics(const Services& services) {
  return Response{
      .content_type = "text/plain; version=0.0.4; charset=utf-8",
      .body = services.metrics->render({.sessions = services.localization->count_by_status(),
                                        .maps = services.maps->cache_use(),
                                        .ranking = services.ranking->use(),
                                        .load = services.load(),
                                        .process = process_usage(),
                                        .database = database_usage(services.stores->location()),
                                        .jobs = job_counts(services)})};
}

}  // namespace

void add_health_routes(Router& router, const Services& services) {
  router.add({.method = "GET",
              .pattern = "/healthz",
              .access = Access::kPublic,
              .handler = [](const Request&) { return json_response(200, R"({"status":"ok"})"); }});
  router.add({.method = "GET",
              .pattern = "/readyz",
              .access = Access::kPublic,
              .handler = [services](const Request& request) { return ready(services, request); }});
  router.add({.method = "GET",
              .pattern = "/openapi.json",
              .access = Access::kPublic,
              .handler = [](const Request&) {
                return json_response(200, std::string(api::openapi_json()));
              }});
  router.add({.method = "GET",
              .pattern = "/metrics",
              .access = Access::kRead,
              .handler = [services](const Request&) { return metrics(services); }});
}

Router make_router(const Services& services) {
  Router router;
  add_map_routes(router, services);
  add_session_routes(router, services);
  add_job_routes(router, services);
  add_health_routes(router, services);
  return router;
}

}  // namespace cornerfix::server

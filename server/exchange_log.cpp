#include "server/exchange_log.hpp"

#include <string_view>

#include "server/event_log.hpp"
#include "server/request_trace.hpp"

// Last, because its <resolv.h> defines a macro `_res` that breaks Eigen's headers after it.
#include <httplib.h>

namespace cornerfix::server {

void log_exchange(const Exchange& exchange, int status, double ms) {
  const Request& request = exchange.request;
  const bool is_of_session = exchange.route.starts_with("/v1/sessions/{id}");
  const std::string_view session = is_of_session ? request.captures.front() : std::string_view{};
  const bool is_robot = request.principal.role == Role::kRobot;
  log_event("request", {{"request_id", request.id},
                        {"trace_id", trace_id_of(request.traceparent)},
                        {"client", exchange.raw.remote_addr},
                        {"method", exchange.raw.method},
                        {"path", exchange.raw.target.substr(0, exchange.raw.target.find('?'))},
                        {"status", std::int64_t{status}},
                        {"ms", ms},
                        {"session", session},
                        {"robot", is_robot ? request.principal.name : ""}});
}

}  // namespace cornerfix::server

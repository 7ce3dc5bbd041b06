#include "server/responses.hpp"
#include "server/routes.hpp"

namespace cornerfix::server {
namespace {

// Room comes when somebody deletes something: there is no point in asking often.
constexpr std::chrono::seconds kQuotaRetry{60};

}  // namespace

Response over_quota(const Services& services, std::string_view code, std::string detail) {
  services.metrics->count_limited(code);
  return too_many_response(code, std::move(detail), kQuotaRetry);
}

std::optional<Response> refuse_growth(const Services& services, const Request& request) {
  const auto used = services.stores->used_bytes();
  if (!used) return error_response(request, used.error());
  if (*used < services.quotas.database_bytes) return std::nullopt;
  return over_quota(services, "database_full",
                    "The database holds " + std::to_string(*used) +
                        " bytes, as many as it may (max_database_bytes): delete maps or sessions.");
}

}  // namespace cornerfix::server

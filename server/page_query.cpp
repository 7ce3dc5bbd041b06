#include "server/page_query.hpp"

#include "api/requests.hpp"

namespace cornerfix::server {

std::variant<PageQuery, api::Problem> page_query(const Request& request) {
  PageQuery page;
  if (const auto text = request.parameter("limit")) {
    const auto limit = api::parse_page_limit(*text);
    if (const auto* problem = std::get_if<api::Problem>(&limit)) return *problem;
    page.limit = std::get<std::size_t>(limit);
  }
  if (const auto text = request.parameter("page_token")) {
    const auto token = api::parse_number_page_token(*text);
    if (const auto* problem = std::get_if<api::Problem>(&token)) return *problem;
    page.after = static_cast<std::int64_t>(std::get<std::size_t>(token));
  }
  return page;
}

}  // namespace cornerfix::server

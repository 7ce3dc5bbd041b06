/// \file  Which part of a numbered list a query asks for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <variant>

#include "api/problem.hpp"
#include "server/http_message.hpp"

namespace cornerfix::server {

struct PageQuery {
  std::size_t limit = 100;
  std::int64_t after = 0;  ///< Number of the last entry of the page before.
};

/// `limit` and `page_token` of the query.
[[nodiscard]] std::variant<PageQuery, api::Problem> page_query(const Request& request);

}  // namespace cornerfix::server

/// \file  What a parsed request holds.
#pragma once

#include <gtest/gtest.h>

#include <utility>
#include <variant>

#include "api/requests.hpp"

namespace cornerfix::api {

/// The request, or a failed test that prints the problem.
template <typename Request>
[[nodiscard]] Request taken(Parsed<Request> parsed) {
  if (const auto* problem = std::get_if<Problem>(&parsed)) {
    ADD_FAILURE() << render(*problem);
    return {};
  }
  return std::get<Request>(std::move(parsed));
}

}  // namespace cornerfix::api

/// \file  Errors as RFC 9457 problem documents, and the one table from error code to HTTP status.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/result.hpp>

namespace cornerfix::api {

/// A wrong part of a request.
struct FieldError {
  std::string pointer;  ///< JSON pointer, "/scans/3/ranges/17".
  std::string detail;
};

struct Problem {
  int status = 500;
  std::string code;  ///< Stable, snake_case: "invalid_argument", "sequence_conflict", …
  std::string title;
  std::string detail;
  std::vector<FieldError> errors;
  std::string extra_json;  ///< Members to merge, e.g. {"expected": 3}; empty for none.
};

[[nodiscard]] int http_status(ErrorCode code);
[[nodiscard]] Problem to_problem(const Error& error);
/// application/problem+json body.
[[nodiscard]] std::string render(const Problem& problem);

}  // namespace cornerfix::api

/// \file  Errors as RFC 9457 problem documents, and the one table from error code to HTTP status.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
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

/// Where a session stands, for a robot that posted another batch.
struct SequenceConflict {
  std::uint64_t expected = 0;        ///< Sequence of the next batch.
  std::optional<double> last_stamp;  ///< Of the last scan [s]; null before the first.
};

struct Problem {
  int status = 500;
  std::string code;  ///< Stable, snake_case: "invalid_argument", "conflict", …
  std::string title;
  std::string detail;
  std::vector<FieldError> errors;
  std::optional<SequenceConflict> conflict{};  ///< Adds its members to the document.
};

[[nodiscard]] int http_status(ErrorCode code);

/// A problem with the status, stable code and title that belong to `code`.
[[nodiscard]] Problem make_problem(ErrorCode code, std::string detail);

/// What a caller may know of `error`: the text of internal and corrupt-data errors stays out, it
/// belongs in the log. A `field` becomes an entry of `errors` when the caller's input was wrong.
[[nodiscard]] Problem to_problem(const Error& error);

/// application/problem+json body. `type` is "urn:cornerfix:problem:" and the code. Never fails:
/// bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string render(const Problem& problem);

/// Gathers what is wrong with a request; the first `kMaxListed` are listed.
class FieldErrors {
 public:
  static constexpr std::size_t kMaxListed = 20;

  void add(std::string pointer, std::string detail);
  [[nodiscard]] bool empty() const { return count_ == 0; }
  /// A 422 that lists them.
  [[nodiscard]] Problem to_problem() &&;

 private:
  std::vector<FieldError> listed_;
  std::size_t count_ = 0;
};

}  // namespace cornerfix::api

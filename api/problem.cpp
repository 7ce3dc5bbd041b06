#include "api/problem.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace cornerfix::api {
namespace {

struct CodeInfo {
  int status;
  const char* code;
  const char* title;
};

CodeInfo info_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return {422, "invalid_argument", "Well-formed but wrong"};
    case ErrorCode::kMalformed:
      return {400, "malformed", "Cannot be read"};
    case ErrorCode::kNotFound:
      return {404, "not_found", "Not found"};
    case ErrorCode::kConflict:
      return {409, "conflict", "Not possible in the present state"};
    case ErrorCode::kTooLarge:
      return {413, "too_large", "Above a limit"};
    case ErrorCode::kCorruptData:
      return {500, "corrupt_data", "Stored data is damaged"};
    case ErrorCode::kUnavailable:
      return {503, "unavailable", "Not available now"};
    case ErrorCode::kStorageFull:
      return {507, "storage_full", "No space left to store this"};
    case ErrorCode::kInternal:
      break;
  }
  return {500, "internal", "Internal error"};
}

/// "/a/b" as it is; a parameter's name "a.b" as "/a/b".
std::string as_pointer(const std::string& field) {
  if (field.starts_with('/')) return field;
  std::string pointer = "/" + field;
  std::replace(pointer.begin(), pointer.end(), '.', '/');
  return pointer;
}

}  // namespace

int http_status(ErrorCode code) { return info_of(code).status; }

Problem make_problem(ErrorCode code, std::string detail) {
  const CodeInfo info = info_of(code);
  return {.status = info.status,
          .code = info.code,
          .title = info.title,
          .detail = std::move(detail),
          .errors = {}};
}

Problem to_problem(const Error& error) {
  if (http_status(error.code) == 500) {
    return make_problem(error.code, "The server's log has the details, by the request's id.");
  }
  Problem problem = make_problem(error.code, error.message);
  const bool input_was_wrong =
      problem.status == 400 || problem.status == 413 || problem.status == 422;
  if (input_was_wrong && !error.field.empty()) {
    problem.errors.push_back({as_pointer(error.field), error.message});
  }
  return problem;
}

std::string render(const Problem& problem) {
  nlohmann::ordered_json body = {{"type", "urn:cornerfix:problem:" + problem.code},
                                 {"title", problem.title},
                                 {"status", problem.status},
                                 {"code", problem.code},
                                 {"detail", problem.detail}};
  for (const FieldError& error : problem.errors) {
    body["errors"].push_back({{"pointer", error.pointer}, {"detail", error.detail}});
  }
  if (const auto& conflict = problem.conflict) {
    body["expected"] = conflict->expected;
    body["last_stamp"] =
        conflict->last_stamp ? nlohmann::ordered_json(*conflict->last_stamp) : nullptr;
  }
  return body.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void FieldErrors::add(std::string pointer, std::string detail) {
  if (++count_ <= kMaxListed) listed_.push_back({std::move(pointer), std::move(detail)});
}

Problem FieldErrors::to_problem() && {
  std::string detail;
  if (count_ == 1) {
    detail = listed_.front().pointer + ": " + listed_.front().detail;
  } else {
    detail = std::to_string(count_) + " members are wrong";
    if (count_ > kMaxListed) detail += ", the first " + std::to_string(kMaxListed) + " are listed";
  }
  Problem problem = make_problem(ErrorCode::kInvalidArgument, std::move(detail));
  problem.errors = std::move(listed_);
  return problem;
}

}  // namespace cornerfix::api

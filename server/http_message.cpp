#include "server/http_message.hpp"

namespace cornerfix::server {
namespace {

std::string_view title_of(int status) {
  switch (status) {
    case 400:
      return "Bad request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not found";
    case 405:
      return "Method not allowed";
    case 406:
      return "Not acceptable";
    case 408:
      return "Request timeout";
    case 409:
      return "Conflict";
    case 411:
      return "Length required";
    case 413:
      return "Content too large";
    case 414:
      return "URI too long";
    case 415:
      return "Unsupported media type";
    case 416:
      return "Range not satisfiable";
    case 417:
      return "Expectation failed";
    case 422:
      return "Unprocessable content";
    case 431:
      return "Request header fields too large";
    case 501:
      return "Not implemented";
    case 503:
      return "Service unavailable";
    default:
      return status < 500 ? "Bad request" : "Internal server error";
  }
}

}  // namespace

Response json_response(int status, std::string json) {
  return {.status = status, .content_type = "application/json", .body = std::move(json)};
}

Response problem_response(const api::Problem& problem) {
  Response response{.status = problem.status,
                    .content_type = "application/problem+json",
                    .body = api::render(problem)};
  if (problem.status == 503 || problem.status == 429) {
    response.headers.emplace_back("Retry-After", "1");
  }
  return response;
}

Response problem_response(int status, std::string_view code, std::string detail) {
  return problem_response(api::Problem{.status = status,
                                       .code = std::string(code),
                                       .title = std::string(title_of(status)),
                                       .detail = std::move(detail),
                                       .errors = {},
                                       .extra_json = {}});
}

}  // namespace cornerfix::server

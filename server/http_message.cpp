#include "server/http_message.hpp"

#include <algorithm>

namespace cornerfix::server {
namespace {

constexpr const char* kContentSecurityPolicy =
    "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; "
    "frame-ancestors 'none'";

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
    case 412:
      return "Precondition failed";
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
    case 421:
      return "Misdirected request";
    case 429:
      return "Too many requests";
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

void add_common_headers(Response& response, const std::string& request_id) {
  auto& headers = response.headers;
  const bool has_cache_rule = std::ranges::any_of(
      headers, [](const auto& header) { return header.first == "Cache-Control"; });
  if (!has_cache_rule) headers.emplace_back("Cache-Control", "no-store");
  headers.emplace_back("X-Request-Id", request_id);
  headers.emplace_back("X-Content-Type-Options", "nosniff");
  headers.emplace_back("Content-Security-Policy", kContentSecurityPolicy);
  headers.emplace_back("Referrer-Policy", "no-referrer");
  headers.emplace_back("Vary", "Accept, Accept-Encoding, Authorization");
}

std::string last_answer(const Response& response) {
  std::string text = "HTTP/1.1 " + std::to_string(response.status) + " ";
  text.append(title_of(response.status)).append("\r\n");
  for (const auto& [name, value] : response.headers)
    text.append(name).append(": ").append(value).append("\r\n");
  text.append("Content-Type: ").append(response.content_type).append("\r\n");
  text.append("Content-Length: ").append(std::to_string(response.body.size())).append("\r\n");
  return text.append("Connection: close\r\n\r\n").append(response.body);
}

Response json_response(int status, std::string json) {
  return {.status = status, .content_type = "application/json", .body = std::move(json)};
}

Response problem_response(const api::Problem& problem) {
  Response response{
      .status = problem.status, .content_type = kProblemType, .body = api::render(problem)};
  if (problem.status == 503) response.headers.emplace_back("Retry-After", "1");
  return response;
}

Response problem_response(int status, std::string_view code, std::string detail) {
  return problem_response(api::Problem{.status = status,
                                       .code = std::string(code),
                                       .title = std::string(title_of(status)),
                                       .detail = std::move(detail),
                                       .errors = {},
                                       .conflict = {}});
}

Response too_many_response(std::string_view code, std::string detail, std::chrono::seconds wait) {
  Response response = problem_response(429, code, std::move(detail));
  response.headers.emplace_back("Retry-After", std::to_string(wait.count()));
  return response;
}

}  // namespace cornerfix::server

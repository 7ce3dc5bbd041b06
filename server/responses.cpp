#include "server/responses.hpp"

#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

namespace cornerfix::server {

Response document_response(const Request& request, int status, const api::Json& document) {
  return {.status = status,
          .content_type = std::string(api::media_type(request.answer_format)),
          .body = api::encode(document, request.answer_format)};
}

Response text_response(const Request& request, int status, const std::string& json) {
  if (request.answer_format == api::BodyFormat::kJson) return json_response(status, json);
  return document_response(request, status, api::Json::parse(json));
}

namespace {

/// Text of others cannot begin a line of the log or command a terminal.
std::string printable(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    out += byte >= 0x20 && byte != 0x7f ? std::string(1, c) : fmt::format("\\x{:02x}", byte);
  }
  return out;
}

}  // namespace

Response error_response(const Request& request, const Error& error) {
  const api::Problem problem = api::to_problem(error);
  if (problem.status >= 500) {
    spdlog::error("{} {}{}{}", request.id, printable(error.message),
                  error.field.empty() ? "" : " at ", printable(error.field));
  }
  return problem_response(problem);
}

}  // namespace cornerfix::server
